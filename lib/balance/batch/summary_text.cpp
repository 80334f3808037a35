// A summary for people: on a terminal and as Markdown.

#include "balance/batch/summary_table.hpp"

#include <fmt/format.h>

namespace balance {
namespace {

/// A bar would end the cell.
std::string cell(const std::string& text) {
  std::string safe;
  for (const char c : text) safe += c == '|' ? "\\|" : c == '\n' ? " " : std::string(1, c);
  return safe;
}

std::string markdown_row(const std::vector<std::string>& cells) {
  std::string row = "|";
  for (const std::string& one : cells) row += " " + cell(one) + " |";
  return row + "\n";
}

std::string markdown_table(const Table& table) {
  std::string text = markdown_row(table.heading) + "|";
  for (const Align align : table.align) text += align == Align::right ? " ---: |" : " --- |";
  text += "\n";
  for (const auto& row : table.rows) text += markdown_row(row);
  return text;
}

}  // namespace

std::string summary_text(const Summary& summary) {
  std::string text = summary.name + "\n\n" + format_table(case_table(summary));
  Table requirements{{"requirement", "case", "verdict"}, {Align::left, Align::left, Align::left}, {}};
  for (const RequirementOutcome& one : summary.requirements)
    requirements.rows.push_back({one.text, one.run, one.message});
  if (!requirements.rows.empty()) text += "\n" + format_table(requirements);
  bool first = true;
  for (const CaseRecord& record : summary.cases) {
    if (record.message.empty()) continue;
    text += fmt::format("{}{}: {}\n", first ? "\n" : "", record.name, record.message);
    first = false;
  }
  return text + "\n" + in_one_line(summary) + "\n";
}

std::string summary_markdown(const Summary& summary) {
  std::string text = fmt::format("# {}\n\n{}.\n\n## Cases\n\n", summary.name, in_one_line(summary));
  text += markdown_table(case_table(summary));
  if (!summary.baseline.empty()) text += fmt::format("\nThe baseline is {}.\n", summary.baseline);
  if (!summary.requirements.empty()) {
    Table table{{"requirement", "case", "status", "verdict"}, {Align::left, Align::left, Align::left, Align::left}, {}};
    for (const RequirementOutcome& one : summary.requirements)
      table.rows.push_back({"`" + one.text + "`", one.run, name_of(one.status), one.message});
    text += "\n## Requirements\n\n" + markdown_table(table);
  }
  std::string troubles;
  for (const CaseRecord& record : summary.cases)
    if (!record.message.empty()) troubles += fmt::format("- {} ({}): {}\n", record.name, record.status, record.message);
  return troubles.empty() ? text : text + "\n## What went wrong\n\n" + troubles;
}

}  // namespace balance
