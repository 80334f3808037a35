#pragma once
/// What is wrong with a command line that the parser refused, in the program's words.

#include <CLI/CLI.hpp>

#include <string>

namespace balance::app {

/// One line: the option or argument, what was expected and what is nearest to it.
/// @param command that was called, after it was parsed
std::string describe_mistake(CLI::App& command, const CLI::ParseError& error);

/// "balance" or "balance check".
std::string call_of(const CLI::App& command);

/// What to do for people who try an option of other programs; else empty.
std::string cure_for(const std::string& word);

/// @throws CallError if an operand, or an option that takes a file's or a folder's name, was given an empty one
void refuse_empty_names(CLI::App& command);

}  // namespace balance::app
