#pragma once
/// Wording of messages: suggestions for misspelt names and numbers, lists, counts.

#include <string>
#include <string_view>
#include <vector>

namespace balance {

/// Number of insertions, deletions, replacements and transpositions of neighbours that turn one word into the other. A
/// difference in case counts as a quarter, so that `L` is nearer to `l` than to `g`.
double edit_distance(std::string_view a, std::string_view b);

/// The name that `word` is probably a misspelling of; empty if there is none. In this order: its plural or singular;
/// the nearest name, if less than half of the longer word differs or, in words of up to five letters, one letter
/// (leading dashes do not count); the first name that begins with `word` or that `word` begins with.
std::string find_nearest_name(std::string_view word, const std::vector<std::string>& names);

/// "nearest is 'crank1'"; empty if no name is near.
std::string format_nearest_name(std::string_view word, const std::vector<std::string>& names);

/// The same as a suffix of a sentence: "; nearest is 'crank1'".
std::string append_nearest_name(std::string_view word, const std::vector<std::string>& names);

/// "use a decimal point: 0.4" if the text has a number with a decimal comma outside parentheses, else empty.
std::string suggest_decimal_point(std::string_view text);

/// The same as a suffix of a sentence: "; use a decimal point: 0.4".
std::string format_decimal_point_hint(std::string_view text);

/// "a, b <last> c"; long lists are truncated.
std::string join_with_conjunction(const std::vector<std::string>& names, const std::string& last);

/// "1 start", "3 starts".
std::string count_noun(long count, const char* one, const char* many);

/// "a, b or c".
std::string join_alternatives(const std::vector<std::string>& names);

/// The text in single quotes, truncated and with invisible characters escaped (foundation/base/unicode_text.hpp).
std::string quote_for_message(std::string_view text);

/// Whether a name is a pattern, in which a star stands for any characters.
inline bool has_wildcards(std::string_view name) { return name.find('*') != std::string_view::npos; }

/// Whether such a pattern matches the whole text, with at most one step per star and character.
bool is_glob_match(std::string_view name, std::string_view text);

}  // namespace balance
