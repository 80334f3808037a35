#pragma once
/// Scripts that complete the program's command line in a shell. They are self-contained: the program is not run while
/// the user types.

#include "cli/help.hpp"

namespace balance::app {

std::string bash_completion(const ProgramHelp& help);
std::string zsh_completion(const ProgramHelp& help);
std::string fish_completion(const ProgramHelp& help);

}  // namespace balance::app
