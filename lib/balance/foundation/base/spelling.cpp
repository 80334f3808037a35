#include "balance/foundation/base/spelling.hpp"

#include "balance/foundation/base/unicode_text.hpp"

#include <algorithm>
#include <cctype>

namespace balance {

namespace {

constexpr std::size_t max_compared_length = 64;
constexpr std::size_t min_common_prefix = 3;  ///< minimum length of a shared beginning

/// Maximum edit distance of a misspelt word; beyond it, it is a different word. One error plus a difference in case is
/// accepted even in words of two letters.
/// @param length of the longer word
double max_edit_distance(std::size_t length) {
  constexpr double max_difference_fraction = 0.45, max_short_word_difference = 1.25;
  constexpr std::size_t max_short_word_length = 5;
  if (length < 2) return 0.25;
  return length <= max_short_word_length ? max_short_word_difference
                                         : max_difference_fraction * static_cast<double>(length);
}

/// An option's name without the leading dashes that all options have.
std::string_view strip_dashes(std::string_view word) {
  return word.substr(std::min(word.find_first_not_of('-'), word.size()));
}

/// Whether `name` is the plural of `word`: bodies of body.
bool is_plural_of(std::string_view name, std::string_view word) {
  if (word.ends_with('y'))
    return name.ends_with("ies") && name.substr(0, name.size() - 3) == word.substr(0, word.size() - 1);
  return name.ends_with('s') && name.substr(0, name.size() - 1) == word;
}

double substitution_cost(char a, char b) {
  if (a == b) return 0;
  const auto lower = [](char c) { return std::tolower(static_cast<unsigned char>(c)); };
  return lower(a) == lower(b) ? 0.25 : 1;
}

}  // namespace

double edit_distance(std::string_view a, std::string_view b) {
  a = a.substr(0, max_compared_length);
  b = b.substr(0, max_compared_length);
  std::vector<std::vector<double>> d(a.size() + 1, std::vector<double>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = static_cast<double>(i);
  for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = static_cast<double>(j);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    for (std::size_t j = 1; j <= b.size(); ++j) {
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + substitution_cost(a[i - 1], b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  }
  return d[a.size()][b.size()];
}

std::string find_nearest_name(std::string_view given, const std::vector<std::string>& names) {
  const std::string_view word = strip_dashes(given);
  const auto length = [](std::string_view text) { return std::min(text.size(), max_compared_length); };
  const std::string* nearest = nullptr;
  double min_distance = 0;
  for (const std::string& candidate : names) {
    const std::string_view name = strip_dashes(candidate);
    if (!word.empty() && (is_plural_of(name, word) || is_plural_of(word, name))) return candidate;
    const double limit = max_edit_distance(std::max(length(word), length(name)));
    // the difference in length bounds the distance from below: most of thousands of names need no closer look
    const std::size_t length_difference = std::max(length(word), length(name)) - std::min(length(word), length(name));
    if (static_cast<double>(length_difference) > limit ||
        (nearest != nullptr && static_cast<double>(length_difference) >= min_distance))
      continue;
    const double distance = edit_distance(word, name);
    if (distance <= limit && (nearest == nullptr || distance < min_distance))
      nearest = &candidate, min_distance = distance;
  }
  if (nearest != nullptr) return *nearest;
  const auto prefix_match = std::find_if(names.begin(), names.end(), [&](const std::string& candidate) {
    const std::string_view name = strip_dashes(candidate);
    return std::min(word.size(), name.size()) >= min_common_prefix &&
           (name.starts_with(word) || word.starts_with(name));
  });
  return prefix_match == names.end() ? "" : *prefix_match;
}

std::string format_nearest_name(std::string_view word, const std::vector<std::string>& names) {
  const std::string nearest = find_nearest_name(word, names);
  return nearest.empty() ? "" : "nearest is " + quote_for_message(nearest);
}

std::string append_nearest_name(std::string_view word, const std::vector<std::string>& names) {
  const std::string suggestion = format_nearest_name(word, names);
  return suggestion.empty() ? "" : "; " + suggestion;
}

namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Digits in groups of three with `separator` between them, the first group of one to three: 1.234.567.
bool has_digit_groups(std::string_view text, char separator) {
  std::size_t at = text.find(separator);
  if (at == std::string_view::npos || at == 0 || at > 3) return false;
  for (; at < text.size(); at += 4)
    if (text[at] != separator || at + 4 > text.size() || !std::all_of(&text[at + 1], &text[at + 1] + 3, is_digit))
      return false;
  return true;
}

std::string remove_character(std::string_view text, char separator) {
  std::string remaining(text);
  std::erase(remaining, separator);
  return remaining;
}

/// A number that contains a comma, rewritten with a decimal point; empty if it is ambiguous. @param text digits, points
/// and commas
std::string replace_decimal_comma(std::string_view text) {
  const std::size_t comma = text.rfind(','), point = text.rfind('.');
  const auto commas = std::count(text.begin(), text.end(), ',');
  if (point == std::string_view::npos) {
    if (commas == 1) return std::string(text.substr(0, comma)) + "." + std::string(text.substr(comma + 1));
    return has_digit_groups(text, ',') ? remove_character(text, ',') : "";
  }
  if (comma < point)
    return has_digit_groups(text.substr(0, point), ',')
               ? remove_character(text.substr(0, point), ',') + std::string(text.substr(point))
               : "";
  if (commas > 1 || !has_digit_groups(text.substr(0, comma), '.')) return "";
  return remove_character(text.substr(0, comma), '.') + "." + std::string(text.substr(comma + 1));
}

}  // namespace

std::string suggest_decimal_point(std::string_view text) {
  const auto is_number_character = [&](std::size_t at) {
    return is_digit(text[at]) ||
           ((text[at] == ',' || text[at] == '.') && at + 1 < text.size() && is_digit(text[at + 1]));
  };
  int depth = 0;
  for (std::size_t at = 0; at < text.size(); ++at) {
    depth += text[at] == '(' ? 1 : text[at] == ')' ? -1 : 0;
    if (depth > 0 || !is_digit(text[at])) continue;
    std::size_t end = at;
    while (end < text.size() && is_number_character(end)) ++end;
    const std::string_view number = text.substr(at, end - at);
    const bool in_name = at > 0 && (std::isalpha(static_cast<unsigned char>(text[at - 1])) != 0 || text[at - 1] == '_');
    at = end - 1;
    if (in_name || number.find(',') == std::string_view::npos) continue;
    const std::string corrected = replace_decimal_comma(number);
    return "use a decimal point" + (corrected.empty() ? " and no thousands separators" : ": " + corrected);
  }
  return "";
}

std::string format_decimal_point_hint(std::string_view text) {
  const std::string suggestion = suggest_decimal_point(text);
  return suggestion.empty() ? "" : "; " + suggestion;
}

std::string join_with_conjunction(const std::vector<std::string>& names, const std::string& last) {
  constexpr std::size_t max_listed_names = 24;
  std::string text;
  const std::size_t shown = std::min(names.size(), max_listed_names);
  for (std::size_t i = 0; i < shown; ++i) {
    if (i > 0) text += i + 1 == names.size() ? " " + last + " " : ", ";
    text += names[i];
  }
  return shown < names.size() ? text + ", …" : text;
}

std::string count_noun(long count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

std::string join_alternatives(const std::vector<std::string>& names) { return join_with_conjunction(names, "or"); }

std::string quote_for_message(std::string_view text) {
  constexpr std::size_t max_quoted_length = 60;
  std::size_t end = std::min(text.size(), max_quoted_length);
  // Do not split a UTF-8 character.
  while (end < text.size() && end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;
  return "'" + escape_for_terminal(text.substr(0, end)) + (end < text.size() ? "…" : "") + "'";
}

bool is_glob_match(std::string_view name, std::string_view text) {
  std::size_t n = 0, t = 0, star = std::string_view::npos, consumed = 0;
  while (t < text.size()) {
    if (n < name.size() && name[n] == '*') {
      star = n++;
      consumed = t;
    } else if (n < name.size() && name[n] == text[t]) {
      ++n, ++t;
    } else if (star != std::string_view::npos) {
      n = star + 1;
      t = ++consumed;
    } else {
      return false;
    }
  }
  while (n < name.size() && name[n] == '*') ++n;
  return n == name.size();
}

}  // namespace balance
