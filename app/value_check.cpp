#include "value_check.hpp"

#include "suggestion.hpp"

#include "balance/base/nearest.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace balance::app {
namespace {

template <class Number>
bool parse_all(const std::string& text, Number& number) {
  const char* const begin = text.data() + (text.starts_with('+') ? 1 : 0);
  const char* const end = text.data() + text.size();
  const auto [rest, wrong] = std::from_chars(begin, end, number);
  return wrong == std::errc() && rest == end;
}

/// "a number from 2 to 100", "a number of at least 2"
template <class Number>
std::string range_text(const char* what, Number lower, Number upper, bool bounded) {
  return bounded ? fmt::format("{} from {} to {}", what, lower, upper) : fmt::format("{} of at least {}", what, lower);
}

template <class Number>
CLI::Validator number_check(const std::string& expected, Number lower, Number upper) {
  const auto check = [=](const std::string& text) -> std::string {
    Number number = 0;
    if (parse_all(text, number) && number >= lower && number <= upper) return "";
    return fmt::format("expected {}, found {}{}", expected, in_quotes(text), decimal_comma_hint(text));
  };
  return {[check](std::string& text) { return check(text); }, ""};
}

}  // namespace

CLI::Validator whole_number(long lower, long upper) {
  return number_check(range_text("a whole number", lower, upper, upper < std::numeric_limits<long>::max()), lower,
                      upper);
}

CLI::Validator number_between(double lower, double upper) {
  return number_check(range_text("a number", lower, upper, std::isfinite(upper)), lower, upper);
}

void require_word(CLI::Option* option, const std::vector<std::string>& words) {
  suggest_words(option, words);
  const auto check = [words](const std::string& text) -> std::string {
    if (std::find(words.begin(), words.end(), text) != words.end()) return "";
    return fmt::format("expected {}, found {}{}", one_of(words), in_quotes(text), nearest_hint(text, words));
  };
  option->check(CLI::Validator([check](std::string& text) { return check(text); }, ""));
}

}  // namespace balance::app
