// A summary for people: on a terminal and as Markdown.

#include "balance/base/plain_text.hpp"
#include "balance/batch/summary_table.hpp"
#include "balance/present/markdown.hpp"

#include <fmt/format.h>

namespace balance {
std::string summary_text(const Summary& summary) {
  std::string text = summary.name + "\n\n" + format_table(case_table(summary));
  Table requirements{{"requirement", "case", "verdict"}, {Align::left, Align::left, Align::left}, {}};
  for (const RequirementOutcome& one : summary.requirements)
    requirements.rows.push_back({one.text, one.run, one.message});
  if (!requirements.rows.empty()) text += "\n" + format_table(requirements);
  bool first = true;
  for (const CaseRecord& record : summary.cases) {
    if (record.message.empty()) continue;
    text += fmt::format("{}{}: {}\n", first ? "\n" : "", visible(record.name), visible(record.message));
    first = false;
  }
  return text + "\n" + in_one_line(summary) + "\n";
}

std::string failures_text(const Summary& summary) {
  std::string text;
  for (const CaseRecord& record : summary.cases)
    if (record.status != "done") text += fmt::format("FAILED {}: {}\n", visible(record.name), visible(record.message));
  for (const RequirementOutcome& one : summary.requirements)
    if (one.status == RequirementOutcome::Status::missed || one.status == RequirementOutcome::Status::wrong)
      text += fmt::format("FAILED {}: {}\n", visible(title_of(one)), visible(one.message));
  return text;
}

std::string summary_markdown(const Summary& summary) {
  std::string text = fmt::format("# {}\n\n{}.\n\n## Cases\n\n", markdown_text(summary.name), in_one_line(summary));
  text += markdown_table(case_table(summary));
  if (!summary.baseline.empty()) text += fmt::format("\nThe baseline is {}.\n", markdown_text(summary.baseline));
  if (!summary.requirements.empty()) {
    Table table{{"requirement", "case", "status", "verdict"}, {Align::left, Align::left, Align::left, Align::left}, {}};
    for (const RequirementOutcome& one : summary.requirements)
      table.rows.push_back({one.text, one.run, name_of(one.status), one.message});
    text += "\n## Requirements\n\n" + markdown_table(table, {0});
  }
  std::string troubles;
  for (const CaseRecord& record : summary.cases)
    if (!record.message.empty())
      troubles +=
          fmt::format("- {} ({}): {}\n", markdown_text(record.name), record.status, markdown_text(record.message));
  return troubles.empty() ? text : text + "\n## What went wrong\n\n" + troubles;
}

}  // namespace balance
