#include "help_model.hpp"

#include "balance/base/version.hpp"

#include <sstream>
#include <string_view>

namespace balance::app {
namespace {

constexpr std::string_view examples_head = "Examples:\n";

OptionHelp describe(CLI::Option& option) {
  OptionHelp help;
  for (const std::string& name : option.get_snames()) help.shorts.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) help.longs.push_back("--" + name);
  if (option.get_items_expected_max() > 0) help.value = value_name(option);
  help.text = option.get_description();
  help.default_value = option.get_default_str();
  help.required = option.get_required();
  help.repeats = option.get_items_expected_max() > 1;
  help.suggestion = find_value_completion(option);
  return help;
}

std::vector<std::string> split(const std::string& text, const std::string& separator) {
  std::vector<std::string> parts;
  std::size_t at = 0;
  while (at < text.size()) {
    const std::size_t end = std::min(text.find(separator, at), text.size());
    if (end > at) parts.push_back(text.substr(at, end - at));
    at = end + separator.size();
  }
  return parts;
}

std::string trimmed(const std::string& text) { return text.substr(std::min(text.find_first_not_of(' '), text.size())); }

}  // namespace

CommandHelp describe_command(CLI::App& parser) {
  CommandHelp help;
  help.name = parser.get_name();
  help.summary = parser.get_description();
  help.group = parser.get_group();
  for (const std::string& paragraph : split(parser.get_footer(), "\n\n")) {
    if (!paragraph.starts_with(examples_head)) {
      help.paragraphs.push_back(paragraph);
      continue;
    }
    for (const std::string& line : split(paragraph.substr(examples_head.size()), "\n"))
      help.examples.push_back(trimmed(line));
  }
  for (CLI::Option* option : parser.get_options()) {
    if (option->get_group().empty()) continue;  // hidden
    (option->get_positional() ? help.operands : help.options).push_back(describe(*option));
  }
  return help;
}

ProgramHelp describe_program(CLI::App& program) {
  ProgramHelp help;
  help.version = version();
  help.program = describe_command(program);
  for (CLI::App* command : program.get_subcommands([](CLI::App*) { return true; })) {
    if (!command->get_group().empty()) help.commands.push_back(describe_command(*command));
  }
  return help;
}

std::string value_name(CLI::Option& option) {
  // "N:INT in [2 - 100]": CLI11 adds its checks to the name of the value.
  const std::string type = option.get_type_name();
  return type.empty() ? "VALUE" : type.substr(0, type.find(':'));
}

std::vector<std::string> names_of(const OptionHelp& option) {
  std::vector<std::string> names = option.shorts;
  names.insert(names.end(), option.longs.begin(), option.longs.end());
  return names;
}

}  // namespace balance::app
