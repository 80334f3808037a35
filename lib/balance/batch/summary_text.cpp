// A summary for people: on a terminal and as Markdown.

#include "balance/base/plain_text.hpp"
#include "balance/batch/summary_table.hpp"
#include "balance/present/markdown.hpp"

#include <fmt/format.h>

namespace balance {
std::string format_batch_text(const BatchSummary& summary) {
  std::string text = summary.name + "\n\n" + format_table(case_table(summary));
  TextTable requirements{{"requirement", "case", "verdict"}, {Align::left, Align::left, Align::left}, {}};
  for (const RequirementOutcome& one : summary.requirements)
    requirements.rows.push_back({one.text, one.run, one.message});
  if (!requirements.rows.empty()) text += "\n" + format_table(requirements);
  bool first = true;
  for (const CaseRecord& record : summary.cases) {
    if (record.message.empty()) continue;
    text += fmt::format("{}{}: {}\n", first ? "\n" : "", escape_for_terminal(record.name),
                        escape_for_terminal(record.message));
    first = false;
  }
  return text + "\n" + format_summary_line(summary) + "\n";
}

std::string format_failures(const BatchSummary& summary) {
  std::string text;
  for (const CaseRecord& record : summary.cases)
    if (record.status != "done")
      text += fmt::format("FAILED {}: {}\n", escape_for_terminal(record.name), escape_for_terminal(record.message));
  for (const RequirementOutcome& one : summary.requirements)
    if (one.status == RequirementOutcome::Status::violated || one.status == RequirementOutcome::Status::invalid)
      text +=
          fmt::format("FAILED {}: {}\n", escape_for_terminal(requirement_title(one)), escape_for_terminal(one.message));
  return text;
}

std::string summary_markdown(const BatchSummary& summary) {
  std::string text =
      fmt::format("# {}\n\n{}.\n\n## Cases\n\n", escape_markdown(summary.name), format_summary_line(summary));
  text += format_markdown_table(case_table(summary));
  if (!summary.baseline.empty()) text += fmt::format("\nThe baseline is {}.\n", escape_markdown(summary.baseline));
  if (!summary.requirements.empty()) {
    TextTable table{
        {"requirement", "case", "status", "verdict"}, {Align::left, Align::left, Align::left, Align::left}, {}};
    for (const RequirementOutcome& one : summary.requirements)
      table.rows.push_back({one.text, one.run, requirement_status_name(one.status), one.message});
    text += "\n## Requirements\n\n" + format_markdown_table(table, {0});
  }
  std::string troubles;
  for (const CaseRecord& record : summary.cases)
    if (!record.message.empty())
      troubles +=
          fmt::format("- {} ({}): {}\n", escape_markdown(record.name), record.status, escape_markdown(record.message));
  return troubles.empty() ? text : text + "\n## What went wrong\n\n" + troubles;
}

}  // namespace balance
