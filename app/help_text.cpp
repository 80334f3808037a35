#include "help_text.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <sstream>

namespace balance::app {
namespace {

constexpr int max_help_width = 80, min_help_width = 40;
constexpr std::size_t max_term_columns =
    26;  ///< columns of an option's names; the text of longer ones begins on the next line

/// Words in lines of the width; from the second on behind an indent.
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

}  // namespace balance::app
