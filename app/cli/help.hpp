#pragma once
/// The program's command line interface as plain values, from which help texts, man pages and shell completions are
/// generated.

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace balance::app {

/// Completions that a shell offers for the value of an option. They are stored in the parser's definition of the
/// option, so that completion always agrees with parsing.
struct ValueCompletion {
  enum class Kind { nothing, words, files };
  Kind kind = Kind::nothing;
  std::vector<std::string> items;  ///< the words, or the file suffixes such as "yaml" (empty: any file)
};

/// Offers words of a fixed set. The option still accepts any text; its command reports invalid words.
void suggest_words(CLI::Option* option, const std::vector<std::string>& words);

/// Offers files with these suffixes (without the dot); any file if there are no suffixes.
void suggest_files(CLI::Option* option, const std::vector<std::string>& suffixes);

/// The registered suggestion. Without one, the name of the value decides: `SPEC`: *.yaml and *.yml, `RESULT`: *.h5,
/// `FILE`: any file.
ValueCompletion find_value_completion(CLI::Option& option);

struct OptionHelp {
  std::vector<std::string> shorts, longs;  ///< including dashes: "-o", "--output"; empty for an operand
  std::string value;                       ///< name of the value, "FILE"; empty for a flag
  std::string text;
  std::string default_value;  ///< empty if there is none or it is not shown
  bool required = false;
  bool repeats = false;
  ValueCompletion suggestion;

  bool takes_value() const { return !value.empty(); }
};

struct CommandHelp {
  std::string name, summary;
  std::string group;                    ///< heading in the program's list of commands
  std::vector<std::string> paragraphs;  ///< help texts below the options, without the examples
  std::vector<std::string> examples;    ///< command lines
  std::vector<OptionHelp> operands, options;
};

struct ProgramHelp {
  std::string version;
  CommandHelp program;
  std::vector<CommandHelp> commands;  ///< without hidden commands
};

ProgramHelp describe_program(CLI::App& program);

/// Describes a single command, which may be hidden.
CommandHelp describe_command(CLI::App& parser);

/// The name of the option's value in help texts: "FILE"; `VALUE` by default.
std::string value_name(CLI::Option& option);

/// All names of the option: short ones first, then long ones.
std::vector<std::string> names_of(const OptionHelp& option);

// Help texts for terminals.

/// Width of help texts in columns: that of the terminal, at most 80; 80 if stdout is not a terminal.
int help_width();

/// Lists the commands by group. Examples are never wrapped, so that they can be copied.
std::string help_text(const ProgramHelp& help, int width);
std::string help_text(const CommandHelp& command, int width);

}  // namespace balance::app
