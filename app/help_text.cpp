#include "help_text.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <sstream>

namespace balance::app {
namespace {

constexpr int widest = 80, narrowest = 40;
constexpr std::size_t max_head = 26;  ///< columns of an option's names; the text of longer ones begins on the next line

/// Words in lines of the width; from the second on behind an indent.
std::string filled(const std::string& begin, const std::string& text, std::size_t indent, std::size_t width) {
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

struct Entry {
  std::string head, text;
};

std::string listed(const std::vector<Entry>& entries, std::size_t width) {
  std::size_t column = 0;
  for (const Entry& entry : entries)
    if (entry.head.size() <= max_head) column = std::max(column, entry.head.size() + 4);
  std::string out;
  for (const Entry& entry : entries) {
    const bool fits = entry.head.size() + 4 <= column;
    if (!fits) out += "  " + entry.head + "\n";
    out += filled(fits ? fmt::format("  {:<{}}", entry.head, column - 2) : std::string(column, ' '), entry.text, column,
                  width);
  }
  return out;
}

Entry entry_of(const OptionHelp& option) {
  const std::string names = fmt::format("{}", fmt::join(names_of(option), ","));
  Entry entry{names.empty() ? option.value : names + (option.takes_value() ? " " + option.value : ""), option.text};
  if (!option.preset.empty()) entry.text += " [" + option.preset + "]";
  return entry;
}

std::string ending(const CommandHelp& command, std::size_t width) {
  std::string out;
  for (const std::string& paragraph : command.paragraphs) out += "\n" + filled("", paragraph, 0, width);
  if (command.examples.empty()) return out;
  out += "\nExamples:\n";
  for (const std::string& example : command.examples) out += "  " + example + "\n";
  return out;
}

std::vector<Entry> entries_of(const std::vector<OptionHelp>& options) {
  std::vector<Entry> entries;
  for (const OptionHelp& option : options) entries.push_back(entry_of(option));
  return entries;
}

}  // namespace

int help_width() {
  winsize size{};
  if (::isatty(STDOUT_FILENO) != 1 || ::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return widest;
  return std::clamp(static_cast<int>(size.ws_col), narrowest, widest);
}

std::string help_text(const ProgramHelp& help, int columns) {
  const auto width = static_cast<std::size_t>(columns);
  std::string out = filled("", help.program.summary, 0, width) + "Usage: balance COMMAND [OPTION]...\n";
  std::string group;
  for (std::size_t i = 0; i < help.commands.size(); ++i) {
    if (help.commands[i].group == group) continue;
    group = help.commands[i].group;
    std::vector<Entry> entries;
    for (const CommandHelp& command : help.commands)
      if (command.group == group) entries.push_back({fmt::format("{:<10}", command.name), command.summary});
    out += "\n" + group + ":\n" + listed(entries, width);
  }
  return out + "\nOptions:\n" + listed(entries_of(help.program.options), width) + ending(help.program, width);
}

std::string help_text(const CommandHelp& command, int columns) {
  const auto width = static_cast<std::size_t>(columns);
  std::string operands;
  for (const OptionHelp& operand : command.operands) {
    const std::string name = operand.value + (operand.repeats ? "..." : "");
    operands += operand.required ? " " + name : " [" + name + "]";
  }
  std::string out = fmt::format("Usage: balance {}{} [OPTION]...\n", command.name, operands);
  out += filled("", command.summary, 0, width);
  if (!command.operands.empty()) out += "\n" + listed(entries_of(command.operands), width);
  return out + "\nOptions:\n" + listed(entries_of(command.options), width) + ending(command, width);
}

}  // namespace balance::app
