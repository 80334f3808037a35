#pragma once
/// Help for misspelt names.

#include <string>
#include <string_view>
#include <vector>

namespace balance {

/// Number of insertions, deletions, replacements and swaps of neighbours that turn one word into the other; upper and
/// lower case count as a quarter of a difference, so that `L` is nearer to `l` than to `g`.
double edit_distance(std::string_view a, std::string_view b);

/// The name nearest to `word`; empty if there are no names.
std::string nearest(std::string_view word, const std::vector<std::string>& names);

/// "nearest is 'crank1'" or, without any names, nothing.
std::string nearest_is(std::string_view word, const std::vector<std::string>& names);

/// The same behind a sentence: "; nearest is 'crank1'".
std::string nearest_hint(std::string_view word, const std::vector<std::string>& names);

/// "a, b <last> c"; long lists are cut.
std::string listed(const std::vector<std::string>& names, const std::string& last);

/// "a, b or c".
std::string one_of(const std::vector<std::string>& names);

/// The text in single quotes, shortened, and visible as in base/plain_text.hpp.
std::string in_quotes(std::string_view text);

}  // namespace balance
