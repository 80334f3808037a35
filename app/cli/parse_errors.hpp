#pragma once
/// What is wrong with a command line that the parser refused, in the program's words.

#include <CLI/CLI.hpp>

#include <string>

namespace balance::app {

/// One line: the option or argument, what was expected and what is nearest to it.
/// @param command that was called, after it was parsed
std::string describe_parse_error(CLI::App& command, const CLI::ParseError& error);

/// "balance" or "balance check".
std::string qualified_command_name(const CLI::App& command);

/// What to do for people who try an option of other programs; else empty.
std::string suggest_option(const std::string& word);

/// @throws SyntaxUsageError if an operand, or an option that takes a file's or a folder's name, was given an empty one
void check_names_not_empty(CLI::App& command);

}  // namespace balance::app
