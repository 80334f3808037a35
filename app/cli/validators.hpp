#pragma once
/// Checks of an option's text. Their messages say what was expected and what was found; help texts do not show them.

#include <CLI/CLI.hpp>

#include <limits>
#include <string>
#include <vector>

namespace balance::app {

CLI::Validator integer_range_validator(long lower,
                                       long upper = std::numeric_limits<long>::max());  ///< both bounds included

CLI::Validator number_range_validator(double lower, double upper);  ///< both bounds included; infinity: none

/// One of the words, which are also what a shell offers.
void add_choice_validator(CLI::Option* option, const std::vector<std::string>& words);

}  // namespace balance::app
