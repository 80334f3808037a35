#include "completion.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace balance::app {
namespace {

std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) {
    if (c == '\'' || c == '\\') result += '\\';
    result += c;
  }
  return result + "'";
}

/// Flags of `complete` that offer the values; -x: one is needed, and no other file will do.
std::string fish_offer(const ValueCompletion& suggestion) {
  switch (suggestion.kind) {
    case ValueCompletion::Kind::words:
      return fmt::format(" -x -a {}", quoted(fmt::format("{}", fmt::join(suggestion.items, " "))));
    case ValueCompletion::Kind::files: {
      if (suggestion.items.empty()) return " -r -F";
      std::vector<std::string> calls;
      for (const std::string& suffix : suggestion.items) calls.push_back("(__fish_complete_suffix ." + suffix + ")");
      return fmt::format(" -x -a {}", quoted(fmt::format("{}", fmt::join(calls, " "))));
    }
    case ValueCompletion::Kind::nothing: break;
  }
  return " -x";
}

std::string option_line(const OptionHelp& option, const std::string& condition) {
  std::string line = fmt::format("complete -c balance -n {}", quoted(condition));
  for (const std::string& name : option.shorts) line += " -s " + name.substr(1);
  for (const std::string& name : option.longs) line += " -l " + name.substr(2);
  line += " -d " + quoted(option.text);
  return line + (option.takes_value() ? fish_offer(option.suggestion) : "") + "\n";
}

}  // namespace

std::string fish_completion(const ProgramHelp& help) {
  const std::string no_command = "__fish_use_subcommand";
  std::string text = "# Completion of balance for fish. Made by `balance completion fish`.\n\ncomplete -c balance -f\n";
  for (const OptionHelp& option : help.program.options) text += option_line(option, no_command);
  for (const CommandHelp& command : help.commands)
    text += fmt::format("complete -c balance -n {} -a {} -d {}\n", quoted(no_command), command.name,
                        quoted(command.summary));
  for (const CommandHelp& command : help.commands) {
    const std::string condition = "__fish_seen_subcommand_from " + command.name;
    text += "\n";
    for (const OptionHelp& option : command.options) text += option_line(option, condition);
    for (const OptionHelp& operand : command.operands)
      text += fmt::format("complete -c balance -n {}{}\n", quoted(condition), fish_offer(operand.suggestion));
  }
  return text;
}

}  // namespace balance::app
