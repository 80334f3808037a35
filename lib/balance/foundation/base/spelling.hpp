#pragma once
/// Words in messages: help for misspelt names and numbers, lists, counts.

#include <string>
#include <string_view>
#include <vector>

namespace balance {

/// Number of insertions, deletions, replacements and swaps of neighbours that turn one word into the other; upper and
/// lower case count as a quarter of a difference, so that `L` is nearer to `l` than to `g`.
double edit_distance(std::string_view a, std::string_view b);

/// The name that `word` is a slip of: its plural or singular; the nearest, if less than half of the longer word differs, and one letter of
/// a word of up to five (dashes before it do not count); else the first that begins with `word`, or it with that; empty if there is none.
std::string find_nearest_name(std::string_view word, const std::vector<std::string>& names);

/// "nearest is 'crank1'" or, if no name is near, nothing.
std::string format_nearest_name(std::string_view word, const std::vector<std::string>& names);

/// The same behind a sentence: "; nearest is 'crank1'".
std::string append_nearest_name(std::string_view word, const std::vector<std::string>& names);

/// "decimals stand behind a point: 0.4" if the text has a number with a decimal comma outside of parentheses; else nothing.
std::string suggest_decimal_point(std::string_view text);

/// The same behind a sentence: "; decimals stand behind a point: 0.4".
std::string format_decimal_point_hint(std::string_view text);

/// "a, b <last> c"; long lists are cut.
std::string join_with_conjunction(const std::vector<std::string>& names, const std::string& last);

/// "1 start", "3 starts".
std::string count_noun(long count, const char* one, const char* many);

/// "a, b or c".
std::string join_alternatives(const std::vector<std::string>& names);

/// The text in single quotes, shortened, and visible as in foundation/base/unicode_text.hpp.
std::string quote_for_message(std::string_view text);

}  // namespace balance
