#pragma once
/// What the parser knows about the program, as plain values: help texts, man pages and completions are made from it.

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace balance::app {

/// What a shell may offer where an option's value is typed. It is kept in the parser's own definition of the option, so
/// that completion cannot disagree with what is parsed.
struct ValueCompletion {
  enum class Kind { nothing, words, files };
  Kind kind = Kind::nothing;
  std::vector<std::string>
      items;  ///< the words; or the suffixes of the files, such as "yaml": any file if there are none
};

/// Offers words of a fixed set. The option still accepts every text: its command says best what is wrong with another.
void suggest_words(CLI::Option* option, const std::vector<std::string>& words);

/// Offers files with these suffixes (without the dot); any file if there are none.
void suggest_files(CLI::Option* option, const std::vector<std::string>& suffixes);

/// What was suggested; else, by the name of the value, `SPEC`: *.yaml and *.yml, `RESULT`: *.h5, `FILE`: any file.
ValueCompletion find_value_completion(CLI::Option& option);

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

// Help as people read it on a terminal.

/// Columns that help may use: those of the terminal, at most 80, or 80 where stdout is no terminal.
int help_width();

/// The commands by their groups. Examples are never broken, to be copied.
std::string help_text(const ProgramHelp& help, int width);
std::string help_text(const CommandHelp& command, int width);

}  // namespace balance::app
