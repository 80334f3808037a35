#include "completion.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace balance::app {
namespace {

/// Characters that mean something in a specification of _arguments, and quotes.
std::string plain(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '[' || c == ']' || c == ':' || c == '\\') escaped += '\\';
    escaped += c == '\'' ? std::string("'\\''") : std::string(1, c);
  }
  return escaped;
}

std::string action(const ValueCompletion& suggestion) {
  switch (suggestion.kind) {
    case ValueCompletion::Kind::words: return fmt::format("({})", fmt::join(suggestion.items, " "));
    case ValueCompletion::Kind::files:
      return suggestion.items.empty() ? "_files"
                                      : fmt::format("_files -g \"*.({})\"", fmt::join(suggestion.items, "|"));
    case ValueCompletion::Kind::nothing: break;
  }
  return " ";
}

std::string operand_line(const OptionHelp& operand) {
  return fmt::format("'{}:{}:{}'", operand.repeats ? "*" : "", plain(operand.value), action(operand.suggestion));
}

/// One specification per name; names of one option exclude each other unless it may be repeated.
std::string option_lines(const OptionHelp& option, const std::string& indent) {
  const std::vector<std::string> names = names_of(option);
  const std::string before = option.repeats ? "*" : names.size() > 1 ? fmt::format("({})", fmt::join(names, " ")) : "";
  std::string lines;
  for (const std::string& name : names) {
    const std::string value =
        option.takes_value() ? fmt::format(":{}:{}", plain(option.value), action(option.suggestion)) : "";
    const char* joined = !option.takes_value() ? "" : name.starts_with("--") ? "=" : "+";
    lines += fmt::format(" \\\n{}'{}{}{}[{}]{}'", indent, before, name, joined, plain(option.text), value);
  }
  return lines;
}

std::string command_case(const CommandHelp& command) {
  std::string text = fmt::format("        {})\n          _arguments -s", command.name);
  for (const OptionHelp& option : command.options) text += option_lines(option, "            ");
  for (const OptionHelp& operand : command.operands) text += " \\\n            " + operand_line(operand);
  return text + "\n          ;;\n";
}

}  // namespace

std::string zsh_completion(const ProgramHelp& help) {
  std::string text =
      "#compdef balance\n# Completion of balance for zsh. Made by `balance completion zsh`.\n\n"
      "_balance() {\n  local context state state_descr line\n  typeset -A opt_args\n"
      "  local -a commands=(\n";
  for (const CommandHelp& command : help.commands)
    text += fmt::format("    '{}:{}'\n", command.name, plain(command.summary));
  text += "  )\n  _arguments -C";
  for (const OptionHelp& option : help.program.options) text += option_lines(option, "    ");
  text +=
      " \\\n    '1:command:->command' \\\n    '*::argument:->argument'\n"
      "  case $state in\n    command) _describe command commands ;;\n    argument)\n      case $line[1] in\n";
  for (const CommandHelp& command : help.commands) text += command_case(command);
  // Autoloaded from $fpath the file is the function itself; sourced, it only says which function completes.
  return text + "      esac\n      ;;\n  esac\n}\n\n" +
         "if [[ $funcstack[1] == _balance ]]; then _balance \"$@\"; else compdef _balance balance; fi\n";
}

}  // namespace balance::app
