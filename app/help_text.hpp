#pragma once
/// Help as people read it on a terminal.

#include <string>

namespace balance::app {

/// Columns that help may use: those of the terminal, at most 100, or 100 where stdout is no terminal.
int help_width();

/// Lines longer than the width go on below where their description begins. Examples stay as they are, to be copied.
std::string wrapped(const std::string& help, int width);

}  // namespace balance::app
