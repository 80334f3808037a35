#include "balance/base/nearest.hpp"

#include "balance/base/plain_text.hpp"

#include <algorithm>
#include <cctype>

namespace balance {

namespace {

constexpr std::size_t longest_compared = 64;
constexpr std::size_t min_prefix = 3;  ///< letters that two names must begin with alike

/// Beyond it a word is another word, not a misspelt one. One slip is one in words of two letters, too.
/// @param length of the longer word
double max_edit_distance(std::size_t length) {
  constexpr double part = 0.45;
  return std::max(length > 1 ? 1 : 0.25, part * static_cast<double>(length));
}

double difference(char a, char b) {
  if (a == b) return 0;
  const auto lower = [](char c) { return std::tolower(static_cast<unsigned char>(c)); };
  return lower(a) == lower(b) ? 0.25 : 1;
}

}  // namespace

double edit_distance(std::string_view a, std::string_view b) {
  a = a.substr(0, longest_compared);
  b = b.substr(0, longest_compared);
  std::vector<std::vector<double>> d(a.size() + 1, std::vector<double>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = static_cast<double>(i);
  for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = static_cast<double>(j);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    for (std::size_t j = 1; j <= b.size(); ++j) {
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + difference(a[i - 1], b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  }
  return d[a.size()][b.size()];
}

std::string nearest(std::string_view word, const std::vector<std::string>& names) {
  const auto length = [](std::string_view text) { return std::min(text.size(), longest_compared); };
  const std::string* best = nullptr;
  double least = 0;
  for (const std::string& name : names) {
    const double limit = max_edit_distance(std::max(length(word), length(name)));
    // every character more or less is a difference: of thousands of names most need no closer look
    const std::size_t apart = std::max(length(word), length(name)) - std::min(length(word), length(name));
    if (static_cast<double>(apart) > limit || (best != nullptr && static_cast<double>(apart) >= least)) continue;
    const double distance = edit_distance(word, name);
    if (distance <= limit && (best == nullptr || distance < least)) best = &name, least = distance;
  }
  if (best != nullptr) return *best;
  const auto begins = std::find_if(names.begin(), names.end(), [&](const std::string& name) {
    return std::min(word.size(), name.size()) >= min_prefix && (name.starts_with(word) || word.starts_with(name));
  });
  return begins == names.end() ? "" : *begins;
}

std::string nearest_is(std::string_view word, const std::vector<std::string>& names) {
  const std::string best = nearest(word, names);
  return best.empty() ? "" : "nearest is " + in_quotes(best);
}

std::string nearest_hint(std::string_view word, const std::vector<std::string>& names) {
  const std::string near = nearest_is(word, names);
  return near.empty() ? "" : "; " + near;
}

std::string decimal_comma_hint(std::string_view text) {
  const auto is_digit = [&](std::size_t at) { return at < text.size() && text[at] >= '0' && text[at] <= '9'; };
  int depth = 0;
  for (std::size_t at = 1; at < text.size(); ++at) {
    depth += text[at - 1] == '(' ? 1 : text[at - 1] == ')' ? -1 : 0;
    if (text[at] != ',' || depth > 0 || !is_digit(at - 1) || !is_digit(at + 1)) continue;
    std::size_t begin = at, end = at + 1;
    while (begin > 0 && is_digit(begin - 1)) --begin;
    while (is_digit(end)) ++end;
    return "; decimals stand behind a point: " + std::string(text.substr(begin, at - begin)) + "." +
           std::string(text.substr(at + 1, end - at - 1));
  }
  return "";
}

std::string listed(const std::vector<std::string>& names, const std::string& last) {
  constexpr std::size_t most = 24;
  std::string text;
  const std::size_t shown = std::min(names.size(), most);
  for (std::size_t i = 0; i < shown; ++i) {
    if (i > 0) text += i + 1 == names.size() ? " " + last + " " : ", ";
    text += names[i];
  }
  return shown < names.size() ? text + ", …" : text;
}

std::string one_of(const std::vector<std::string>& names) { return listed(names, "or"); }

std::string in_quotes(std::string_view text) {
  constexpr std::size_t longest = 60;
  std::size_t end = std::min(text.size(), longest);
  // Do not cut a UTF-8 character in two.
  while (end < text.size() && end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;
  return "'" + visible(text.substr(0, end)) + (end < text.size() ? "…" : "") + "'";
}

}  // namespace balance
