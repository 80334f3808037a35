#pragma once
/// Manual pages in roff with the man macros.

#include "cli/help.hpp"

namespace balance::app {

/// balance(1): the program, its commands, its exit codes.
std::string man_page(const ProgramHelp& help);

/// balance-<command>(1).
std::string man_page(const ProgramHelp& help, const CommandHelp& command);

}  // namespace balance::app
