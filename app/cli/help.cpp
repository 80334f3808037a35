#include "cli/help.hpp"
#include "balance/foundation/base/version.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <optional>
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
  // CLI11 appends the validators to the name of the value: "N:INT in [2 - 100]".
  const std::string type = option.get_type_name();
  return type.empty() ? "VALUE" : type.substr(0, type.find(':'));
}

std::vector<std::string> names_of(const OptionHelp& option) {
  std::vector<std::string> names = option.shorts;
  names.insert(names.end(), option.longs.begin(), option.longs.end());
  return names;
}

namespace {

constexpr int max_help_width = 80, min_help_width = 40;
constexpr std::size_t max_term_columns =
    26;  ///< columns for option names; after longer names the description starts on the next line

/// Fills lines up to the width; indents all lines but the first.
std::string wrap_text(const std::string& begin, const std::string& text, std::size_t indent, std::size_t width) {
  std::istringstream words(text);
  std::string out, line = begin;
  bool first = true;
  for (std::string word; words >> word; first = false) {
    if (!first && line.size() + 1 + word.size() > width) {
      out += line + "\n";
      line = std::string(indent, ' ') + word;
    } else {
      line += (first ? "" : " ") + word;
    }
  }
  return out + line + "\n";
}

struct HelpEntry {
  std::string term, text;
};

std::string format_entries(const std::vector<HelpEntry>& entries, std::size_t width) {
  std::size_t column = 0;
  for (const HelpEntry& entry : entries)
    if (entry.term.size() <= max_term_columns) column = std::max(column, entry.term.size() + 4);
  std::string out;
  for (const HelpEntry& entry : entries) {
    const bool fits = entry.term.size() + 4 <= column;
    if (!fits) out += "  " + entry.term + "\n";
    out += wrap_text(fits ? fmt::format("  {:<{}}", entry.term, column - 2) : std::string(column, ' '), entry.text,
                     column, width);
  }
  return out;
}

HelpEntry make_entry(const OptionHelp& option) {
  const std::string names = fmt::format("{}", fmt::join(names_of(option), ","));
  HelpEntry entry{names.empty() ? option.value : names + (option.takes_value() ? " " + option.value : ""), option.text};
  if (!option.default_value.empty()) entry.text += " [" + option.default_value + "]";
  return entry;
}

std::string format_ending(const CommandHelp& command, std::size_t width) {
  std::string out;
  for (const std::string& paragraph : command.paragraphs) out += "\n" + wrap_text("", paragraph, 0, width);
  if (command.examples.empty()) return out;
  out += "\nExamples:\n";
  for (const std::string& example : command.examples) out += "  " + example + "\n";
  return out;
}

std::vector<HelpEntry> make_entries(const std::vector<OptionHelp>& options) {
  std::vector<HelpEntry> entries;
  for (const OptionHelp& option : options) entries.push_back(make_entry(option));
  return entries;
}

}  // namespace

int help_width() {
  winsize size{};
  if (::isatty(STDOUT_FILENO) != 1 || ::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0)
    return max_help_width;
  return std::clamp(static_cast<int>(size.ws_col), min_help_width, max_help_width);
}

std::string help_text(const ProgramHelp& help, int columns) {
  const auto width = static_cast<std::size_t>(columns);
  std::string out = wrap_text("", help.program.summary, 0, width) + "Usage: balance COMMAND [OPTION]...\n";
  std::string group;
  for (std::size_t i = 0; i < help.commands.size(); ++i) {
    if (help.commands[i].group == group) continue;
    group = help.commands[i].group;
    std::vector<HelpEntry> entries;
    for (const CommandHelp& command : help.commands)
      if (command.group == group) entries.push_back({fmt::format("{:<10}", command.name), command.summary});
    out += "\n" + group + ":\n" + format_entries(entries, width);
  }
  return out + "\nOptions:\n" + format_entries(make_entries(help.program.options), width) +
         format_ending(help.program, width);
}

std::string help_text(const CommandHelp& command, int columns) {
  const auto width = static_cast<std::size_t>(columns);
  std::string operands;
  for (const OptionHelp& operand : command.operands) {
    const std::string name = operand.value + (operand.repeats ? "..." : "");
    operands += operand.required ? " " + name : " [" + name + "]";
  }
  std::string out = fmt::format("Usage: balance {}{} [OPTION]...\n", command.name, operands);
  out += wrap_text("", command.summary, 0, width);
  if (!command.operands.empty()) out += "\n" + format_entries(make_entries(command.operands), width);
  return out + "\nOptions:\n" + format_entries(make_entries(command.options), width) + format_ending(command, width);
}

namespace {

// The suggestions are stored in the name of a validator that always passes; help texts do not show it.
constexpr std::string_view words_mark = "suggest words:";
constexpr std::string_view files_mark = "suggest files:";

void attach(CLI::Option* option, std::string_view mark, const std::vector<std::string>& items) {
  const auto passes = [](std::string&) { return std::string(); };
  option->check(CLI::Validator(passes, "", fmt::format("{}{}", mark, fmt::join(items, ","))));
}

std::vector<std::string> split(std::string_view text) {
  std::vector<std::string> items;
  while (!text.empty()) {
    const std::size_t comma = text.find(',');
    items.emplace_back(text.substr(0, comma));
    text.remove_prefix(comma == std::string_view::npos ? text.size() : comma + 1);
  }
  return items;
}

std::optional<ValueCompletion> read(const CLI::Validator& check) {
  const std::string& name = check.get_name();
  if (name.starts_with(words_mark))
    return ValueCompletion{ValueCompletion::Kind::words, split(name.substr(words_mark.size()))};
  if (name.starts_with(files_mark))
    return ValueCompletion{ValueCompletion::Kind::files, split(name.substr(files_mark.size()))};
  return std::nullopt;
}

/// Reads the validators of the option one by one. CLI11 reports the end only by throwing.
std::optional<ValueCompletion> read_checks(CLI::Option& option) {
  for (int i = 0;; ++i) {
    try {
      if (auto found = read(*option.get_validator(i))) return found;
    } catch (const CLI::OptionNotFound&) {
      return std::nullopt;
    }
  }
}

}  // namespace

void suggest_words(CLI::Option* option, const std::vector<std::string>& words) { attach(option, words_mark, words); }

void suggest_files(CLI::Option* option, const std::vector<std::string>& suffixes) {
  attach(option, files_mark, suffixes);
}

ValueCompletion find_value_completion(CLI::Option& option) {
  if (const auto found = read_checks(option)) return *found;
  const std::string value = option.get_type_name();
  if (value.starts_with("SPEC")) return {ValueCompletion::Kind::files, {"yaml", "yml"}};
  if (value.starts_with("RESULT")) return {ValueCompletion::Kind::files, {"h5"}};
  if (value.starts_with("FILE")) return {ValueCompletion::Kind::files, {}};
  return {};
}

}  // namespace balance::app
