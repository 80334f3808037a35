#include "cli/validators.hpp"

#include "cli/help.hpp"

#include "balance/foundation/base/spelling.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace balance::app {
namespace {

template <class Number>
bool parse_whole_number_text(const std::string& text, Number& number) {
  const char* const begin = text.data() + (text.starts_with('+') ? 1 : 0);
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(begin, end, number);
  return error == std::errc() && rest == end;
}

/// "a number from 2 to 100", "a number of at least 2"
template <class Number>
std::string format_range(const char* what, Number lower, Number upper, bool bounded) {
  return bounded ? fmt::format("{} from {} to {}", what, lower, upper) : fmt::format("{} of at least {}", what, lower);
}

template <class Number>
CLI::Validator make_range_validator(const std::string& expected, Number lower, Number upper) {
  const auto check = [=](const std::string& text) -> std::string {
    Number number = 0;
    if (parse_whole_number_text(text, number) && number >= lower && number <= upper) return "";
    return fmt::format("expected {}, found {}{}", expected, quote_for_message(text), format_decimal_point_hint(text));
  };
  return {[check](std::string& text) { return check(text); }, ""};
}

}  // namespace

CLI::Validator integer_range_validator(long lower, long upper) {
  return make_range_validator(format_range("a whole number", lower, upper, upper < std::numeric_limits<long>::max()),
                              lower, upper);
}

CLI::Validator number_range_validator(double lower, double upper) {
  return make_range_validator(format_range("a number", lower, upper, std::isfinite(upper)), lower, upper);
}

CLI::Validator not_blank_validator(const std::string& what) {
  const auto check = [what](const std::string& text) {
    return text.find_first_not_of(" \t\r\n") == std::string::npos ? "expected " + what + ", found an empty text" : "";
  };
  return {[check](std::string& text) { return check(text); }, ""};
}

void add_choice_validator(CLI::Option* option, const std::vector<std::string>& words) {
  suggest_words(option, words);
  const auto check = [words](const std::string& text) -> std::string {
    if (std::find(words.begin(), words.end(), text) != words.end()) return "";
    return fmt::format("expected {}, found {}{}", join_alternatives(words), quote_for_message(text),
                       append_nearest_name(text, words));
  };
  option->check(CLI::Validator([check](std::string& text) { return check(text); }, ""));
}

}  // namespace balance::app
