#pragma once
/// Parts of option values that CLI11 does not parse.

#include <string>
#include <utility>

namespace balance::app {

/// "A=B". @param form of the value, for the message: "NAME=COLUMN" @throws UsageError
std::pair<std::string, std::string> split_assignment(const std::string& text, const std::string& option,
                                                     const std::string& form);

/// A finite number. @throws UsageError
double parse_number_option(const std::string& text, const std::string& option);

}  // namespace balance::app
