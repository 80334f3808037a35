#pragma once
/// What the parser knows about the program, as plain values: help texts, man pages and completions are made from it.

#include "suggestion.hpp"

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace balance::app {

struct OptionHelp {
  std::vector<std::string> shorts, longs;  ///< with their dashes: "-o", "--output"; none for an operand
  std::string value;                       ///< what its value is called, "FILE"; empty for a flag
  std::string text;
  std::string default_value;  ///< value that it has if it is not given, where that is shown
  bool required = false;
  bool repeats = false;
  ValueCompletion suggestion;

  bool takes_value() const { return !value.empty(); }
};

struct CommandHelp {
  std::string name, summary;
  std::string group;                    ///< of the program's list of commands
  std::vector<std::string> paragraphs;  ///< what the help says below the options, but for the examples
  std::vector<std::string> examples;    ///< commands
  std::vector<OptionHelp> operands, options;
};

struct ProgramHelp {
  std::string version;
  CommandHelp program;
  std::vector<CommandHelp> commands;  ///< without hidden ones
};

ProgramHelp describe_program(CLI::App& program);

/// A command alone, a hidden one too.
CommandHelp describe_command(CLI::App& parser);

/// What a help text calls the option's value: "FILE"; `VALUE` if nobody gave it a name.
std::string value_name(CLI::Option& option);

/// Every name of the option: its short ones and its long ones.
std::vector<std::string> names_of(const OptionHelp& option);

}  // namespace balance::app
