#include "cli/man_page.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>

namespace balance::app {
namespace {

constexpr std::string_view exit_codes_head = "Exit codes: ";

/// Escapes the characters that are special to roff.
std::string roff(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '\\': escaped += "\\(rs"; break;
      case '-': escaped += "\\-"; break;
      case '\'': escaped += "\\(aq"; break;
      case '`': escaped += "\\(ga"; break;
      case '^': escaped += "\\(ha"; break;
      case '~': escaped += "\\(ti"; break;
      case '"': escaped += "\\(dq"; break;
      default: escaped += c;
    }
  }
  return escaped.starts_with('.') ? "\\&" + escaped : escaped;
}

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::toupper(c); });
  return text;
}

/// Joins lines: the line breaks of the help text are meant for terminals.
std::string filled(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return roff(text);
}

/// Omits the date, so that the output is reproducible.
std::string heading(const std::string& title, const std::string& version) {
  return fmt::format(".TH {} 1 \"\" \"balance {}\" \"User Commands\"\n", roff(upper(title)), version);
}

std::string name_section(const std::string& name, const std::string& summary) {
  return fmt::format(".SH NAME\n{} \\- {}\n", roff(name), roff(summary));
}

std::string synopsis(const std::string& words, const std::vector<OptionHelp>& operands) {
  std::string text = fmt::format(".SH SYNOPSIS\n.B {}\n[\\fIOPTIONS\\fR]", roff(words));
  for (const OptionHelp& operand : operands) {
    const std::string name = fmt::format("\\fI{}\\fR{}", roff(operand.value), operand.repeats ? " ..." : "");
    text += operand.required ? " " + name : " [" + name + "]";
  }
  return text + "\n";
}

std::string paragraphs(const std::vector<std::string>& texts) {
  std::string text;
  for (const std::string& paragraph : texts) text += ".PP\n" + filled(paragraph) + "\n";
  return text;
}

std::string head_of(const OptionHelp& option) {
  std::vector<std::string> names;
  for (const std::string& name : names_of(option)) names.push_back("\\fB" + roff(name) + "\\fR");
  const std::string value = option.takes_value() ? "\\fI" + roff(option.value) + "\\fR" : "";
  if (names.empty()) return value;
  return fmt::format("{}{}{}", fmt::join(names, ", "), value.empty() ? "" : " ", value);
}

std::string body_of(const OptionHelp& option) {
  std::string text = roff(option.text);
  if (!option.default_value.empty()) text += " (default: " + roff(option.default_value) + ")";
  return text;
}

std::string option_list(const char* title, const std::vector<OptionHelp>& options) {
  if (options.empty()) return "";
  std::string text = fmt::format(".SH {}\n", title);
  for (const OptionHelp& option : options) text += ".TP\n" + head_of(option) + "\n" + body_of(option) + "\n";
  return text;
}

std::string examples_section(const std::vector<std::string>& examples) {
  if (examples.empty()) return "";
  std::string text = ".SH EXAMPLES\n.nf\n";
  for (const std::string& example : examples) text += roff(example) + "\n";
  return text + ".fi\n";
}

/// The help lists the exit codes in one paragraph, separated by semicolons; the man page makes a list of them.
std::string exit_section(const CommandHelp& program) {
  for (const std::string& paragraph : program.paragraphs) {
    if (!paragraph.starts_with(exit_codes_head)) continue;
    std::string rest = paragraph.substr(exit_codes_head.size());
    std::replace(rest.begin(), rest.end(), '\n', ' ');
    std::string text = ".SH EXIT STATUS\n";
    while (!rest.empty()) {
      const std::size_t space = rest.find(' '), end = std::min(rest.find("; "), rest.size());
      text += fmt::format(".TP\n.B {}\n{}\n", rest.substr(0, space), roff(rest.substr(space + 1, end - space - 1)));
      rest.erase(0, end + 2);
    }
    return text;
  }
  return "";
}

std::string command_list(const ProgramHelp& help) {
  std::string text = ".SH COMMANDS\n";
  for (const CommandHelp& command : help.commands)
    text += fmt::format(".TP\n.B {}\n{}. See\n.BR {} (1).\n", roff(command.name), roff(command.summary),
                        roff("balance-" + command.name));
  return text;
}

/// All other pages.
std::string see_also(const ProgramHelp& help, const std::string& self) {
  std::vector<std::string> pages;
  if (!self.empty()) pages.emplace_back("balance");
  for (const CommandHelp& command : help.commands)
    if (command.name != self) pages.push_back("balance-" + command.name);
  std::string text = ".SH SEE ALSO\n";
  for (const std::string& page : pages)
    text += fmt::format(".BR {} (1){}\n", roff(page), &page == &pages.back() ? "" : ",");
  return text;
}

}  // namespace

std::string man_page(const ProgramHelp& help) {
  std::vector<std::string> texts = help.program.paragraphs;
  std::erase_if(texts, [](const std::string& text) { return text.starts_with(exit_codes_head); });
  const std::string& summary = help.program.summary;
  const std::size_t colon = summary.find(": ");  // "balance: description"
  return heading("balance", help.version) +
         name_section("balance", colon == std::string::npos ? summary : summary.substr(colon + 2)) +
         ".SH SYNOPSIS\n.B balance\n\\fICOMMAND\\fR [\\fIOPTIONS\\fR] ...\n" +
         ".SH DESCRIPTION\nResults go to standard output, messages to standard error.\n" + paragraphs(texts) +
         command_list(help) + option_list("OPTIONS", help.program.options) + examples_section(help.program.examples) +
         exit_section(help.program) + see_also(help, "");
}

std::string man_page(const ProgramHelp& help, const CommandHelp& command) {
  return heading("balance-" + command.name, help.version) + name_section("balance-" + command.name, command.summary) +
         synopsis("balance " + command.name, command.operands) + ".SH DESCRIPTION\n" + roff(command.summary) + ".\n" +
         paragraphs(command.paragraphs) + option_list("OPERANDS", command.operands) +
         option_list("OPTIONS", command.options) + examples_section(command.examples) + exit_section(help.program) +
         see_also(help, command.name);
}

}  // namespace balance::app
