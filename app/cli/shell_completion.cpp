#include "cli/shell_completion.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace balance::app {
namespace {

constexpr const char* head = R"(# Completion of balance for bash. Made by `balance completion bash`.

_balance_words() { mapfile -t COMPREPLY < <(compgen -W "$1" -- "$cur"); }

# Folders, and files with the suffixes given; any file without one.
_balance_files() {
  local suffix
  compopt -o filenames 2>/dev/null
  if [[ $# -eq 0 ]]; then
    mapfile -t COMPREPLY < <(compgen -f -- "$cur")
    return
  fi
  mapfile -t COMPREPLY < <(
    compgen -d -- "$cur"
    for suffix; do compgen -f -X "!*.$suffix" -- "$cur"; done
  )
}
)";

// If `=` is in COMP_WORDBREAKS, it is a separate word in COMP_WORDS.
constexpr const char* tail = R"(
_balance() {
  local cur=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD-1]} command= operand=0 i word
  COMPREPLY=()
  if [[ $cur == = ]]; then
    cur=
  elif [[ $previous == = && $COMP_CWORD -gt 2 ]]; then
    previous=${COMP_WORDS[COMP_CWORD-2]}
  fi
  for ((i = 1; i < COMP_CWORD; i++)); do
    word=${COMP_WORDS[i]}
    if [[ -z $command ]]; then
      [[ $word == -* ]] || command=$word
    elif [[ $word == = ]]; then
      ((i++))
    elif [[ $word == -* ]]; then
      # Its value is no operand; the value of --name=value stands behind a word "=".
      if _balance_has_value "$command" "$word" && [[ ${COMP_WORDS[i+1]} != = ]]; then ((i++)); fi
    else
      ((operand++))
    fi
  done
  if [[ -z $command ]]; then
    if [[ $cur == -* ]]; then _balance_words "$_balance_options"; else _balance_words "$_balance_commands"; fi
  elif _balance_has_value "$command" "$previous"; then
    _balance_value "$command" "$previous"
  elif [[ $cur == -* ]] || ! _balance_operand "$command" "$operand"; then
    _balance_command_options "$command"
  fi
}

complete -F _balance balance
)";

std::string bash_offer(const ValueCompletion& suggestion) {
  const std::string items = fmt::format("{}", fmt::join(suggestion.items, " "));
  switch (suggestion.kind) {
    case ValueCompletion::Kind::words: return fmt::format("_balance_words '{}'", items);
    case ValueCompletion::Kind::files: return items.empty() ? "_balance_files" : "_balance_files " + items;
    case ValueCompletion::Kind::nothing: break;
  }
  return ":";
}

std::string all_names(const std::vector<OptionHelp>& options) {
  std::vector<std::string> names;
  for (const OptionHelp& option : options)
    for (const std::string& name : names_of(option)) names.push_back(name);
  return fmt::format("{}", fmt::join(names, " "));
}

/// Case pattern `command:name` for every name of the option.
std::string pattern_of(const CommandHelp& command, const OptionHelp& option) {
  std::vector<std::string> patterns;
  for (const std::string& name : names_of(option)) patterns.push_back(command.name + ":" + name);
  return fmt::format("{}", fmt::join(patterns, " | "));
}

/// A shell function with a single case statement over command and option or operand.
std::string function(const char* name, const char* key, const std::string& cases, const char* otherwise) {
  return fmt::format("\n{}() {{\n  case {} in\n{}    *) {} ;;\n  esac\n}}\n", name, key, cases, otherwise);
}

std::string operand_cases(const CommandHelp& command) {
  std::string cases;
  for (std::size_t i = 0; i < command.operands.size(); ++i) {
    const OptionHelp& operand = command.operands[i];
    const std::string number = operand.repeats ? "*" : std::to_string(i);
    cases += fmt::format("    {}:{}) {} ;;\n", command.name, number, bash_offer(operand.suggestion));
  }
  return cases;
}

}  // namespace

std::string bash_completion(const ProgramHelp& help) {
  std::vector<std::string> commands;
  std::string options, has_value, values, operands;
  for (const CommandHelp& command : help.commands) {
    commands.push_back(command.name);
    options += fmt::format("    {}) _balance_words '{}' ;;\n", command.name, all_names(command.options));
    operands += operand_cases(command);
    for (const OptionHelp& option : command.options) {
      if (!option.takes_value()) continue;
      has_value += fmt::format("    {}) true ;;\n", pattern_of(command, option));
      values += fmt::format("    {}) {} ;;\n", pattern_of(command, option), bash_offer(option.suggestion));
    }
  }
  return head + fmt::format("\n_balance_commands='{}'\n", fmt::join(commands, " ")) +
         fmt::format("_balance_options='{}'\n", all_names(help.program.options)) +
         function("_balance_has_value", "$1:$2", has_value, "false") +
         function("_balance_value", "$1:$2", values, ":") + function("_balance_operand", "$1:$2", operands, "false") +
         function("_balance_command_options", "$1", options, ":") + tail;
}

namespace {

std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) {
    if (c == '\'' || c == '\\') result += '\\';
    result += c;
  }
  return result + "'";
}

/// Flags of `complete` that offer the values. -x: a value is required, and no other files are offered.
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

namespace {

/// Escapes quotes and the characters that are special in specifications of _arguments.
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

/// One specification per name. The names of an option exclude each other unless the option may be repeated.
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
  // If autoloaded from $fpath, the file is the body of the function; if sourced, it only registers the function.
  return text + "      esac\n      ;;\n  esac\n}\n\n" +
         "if [[ $funcstack[1] == _balance ]]; then _balance \"$@\"; else compdef _balance balance; fi\n";
}

}  // namespace balance::app
