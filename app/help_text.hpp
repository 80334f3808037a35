#pragma once
/// Help as people read it on a terminal.

#include "help_model.hpp"

#include <string>

namespace balance::app {

/// Columns that help may use: those of the terminal, at most 80, or 80 where stdout is no terminal.
int help_width();

/// The commands by their groups. Examples are never broken, to be copied.
std::string help_text(const ProgramHelp& help, int width);
std::string help_text(const CommandHelp& command, int width);

}  // namespace balance::app
