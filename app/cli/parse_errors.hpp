#pragma once
/// Error messages for command lines that the parser rejected.

#include <CLI/CLI.hpp>

#include <string>

namespace balance::app {

/// One line: the option or argument, the expected value and the nearest match.
/// @param command that was called, after parsing
std::string describe_parse_error(CLI::App& command, const CLI::ParseError& error);

/// "balance" or "balance check".
std::string qualified_command_name(const CLI::App& command);

/// Advice for options that other programs have but this one lacks; empty for other words.
std::string suggest_option(const std::string& word);

/// @throws SyntaxUsageError if an operand, or an option that takes a file or folder name, has an empty value
void check_names_not_empty(CLI::App& command);

}  // namespace balance::app
