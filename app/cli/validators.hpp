#pragma once
/// Validators for option values. Their messages state the expected and the actual value; help texts do not show them.

#include <CLI/CLI.hpp>

#include <limits>
#include <string>
#include <vector>

namespace balance::app {

CLI::Validator integer_range_validator(long lower,
                                       long upper = std::numeric_limits<long>::max());  ///< inclusive bounds

CLI::Validator number_range_validator(double lower, double upper);  ///< inclusive bounds; infinity: no bound

/// Refuses a blank text. @param what the expected value in the message
CLI::Validator not_blank_validator(const std::string& what);

/// Restricts the option to these words, which are also offered as completions.
void add_choice_validator(CLI::Option* option, const std::vector<std::string>& words);

}  // namespace balance::app
