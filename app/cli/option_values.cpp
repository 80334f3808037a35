#include "cli/option_values.hpp"

#include "cli/failures.hpp"

#include "balance/foundation/base/spelling.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

namespace balance::app {

std::pair<std::string, std::string> split_assignment(const std::string& text, const std::string& option,
                                                     const std::string& form) {
  const std::size_t equals = text.find('=');
  if (equals == 0 || equals == std::string::npos || equals + 1 == text.size())
    throw UsageError(fmt::format("{}: expected {}, found {}", option, form, quote_for_message(text)));
  return {text.substr(0, equals), text.substr(equals + 1)};
}

double parse_number_option(const std::string& text, const std::string& option) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value))
    throw UsageError(fmt::format("{}: expected a number, found {}", option, quote_for_message(text)));
  return value;
}

}  // namespace balance::app
