#include "balance/batch/summary_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace balance {
namespace {

constexpr std::array<const char*, 3> shown_quantities{"torque", "shaking_force", "shaking_moment"};

const Metric* find(const CaseRecord& record, const std::string& quantity) {
  const auto at = std::find_if(record.metrics.begin(), record.metrics.end(),
                               [&](const Metric& metric) { return metric.quantity == quantity; });
  return at == record.metrics.end() ? nullptr : &*at;
}

struct SummaryColumns {
  std::vector<std::pair<std::string, std::string>> quantities;  ///< that some case has, with units
  bool designs = false;
};

/// A unit only where all cases agree on it.
SummaryColumns choose_columns(const BatchSummary& summary) {
  SummaryColumns columns;
  for (const char* quantity : shown_quantities) {
    std::vector<std::string> units;
    for (const CaseRecord& record : summary.cases)
      if (const Metric* metric = find(record, quantity)) units.push_back(metric->unit);
    if (units.empty()) continue;
    const bool alike = std::all_of(units.begin(), units.end(), [&](const std::string& u) { return u == units[0]; });
    columns.quantities.emplace_back(quantity, alike ? " [" + units[0] + "]" : "");
  }
  columns.designs = std::any_of(summary.cases.begin(), summary.cases.end(),
                                [](const CaseRecord& record) { return record.design.has_value(); });
  return columns;
}

std::string ratio(const Metric& metric, const CaseRecord& base) {
  const Metric* other = find(base, metric.quantity);
  return other == nullptr || !(other->peak > 0) ? "-" : fmt::format("{:.4f}", metric.peak / other->peak);
}

void add_quantity(const CaseRecord& record, const std::string& quantity, const CaseRecord* base,
                  std::vector<std::string>& row) {
  const Metric* metric = find(record, quantity);
  row.push_back(metric == nullptr ? "-" : format_number(metric->peak));
  row.push_back(metric == nullptr ? "-" : format_number(metric->rms));
  if (base != nullptr) row.push_back(metric == nullptr ? "-" : ratio(*metric, *base));
}

}  // namespace

TextTable case_table(const BatchSummary& summary) {
  const SummaryColumns columns = choose_columns(summary);
  const CaseRecord* base = summary.baseline_record();
  TextTable table{{"case", "status"}, {Align::left, Align::left}, {}};
  const auto add_column = [&](const std::string& heading) {
    table.heading.push_back(heading);
    table.align.push_back(Align::right);
  };
  for (const auto& [quantity, unit] : columns.quantities) {
    add_column("peak " + quantity + unit);
    add_column("rms" + unit);
    if (base != nullptr) add_column("peak/base");
  }
  if (columns.designs) add_column("added mass [kg]");
  for (const CaseRecord& record : summary.cases) {
    std::vector<std::string> row = {record.name, record.status};
    for (const auto& [quantity, unit] : columns.quantities) add_quantity(record, quantity, base, row);
    if (columns.designs) row.push_back(record.design ? format_number(record.design->added_mass) : "-");
    table.rows.push_back(std::move(row));
  }
  return table;
}

std::string format_summary_line(const BatchSummary& summary) {
  const auto count = [&](const char* status) {
    return std::count_if(summary.cases.begin(), summary.cases.end(),
                         [&](const CaseRecord& record) { return record.status == status; });
  };
  const auto done = count("done"), compromises = count("compromise"), missing = count("missing");
  const auto failed = static_cast<long>(summary.cases.size()) - done - compromises - missing;
  std::string text =
      fmt::format("{} case{}: {} done", summary.cases.size(), summary.cases.size() == 1 ? "" : "s", done);
  if (compromises > 0) text += fmt::format(", {} only a compromise", compromises);
  if (failed > 0) text += fmt::format(", {} failed", failed);
  if (missing > 0) text += fmt::format(", {} missing", missing);
  if (summary.requirements.empty()) return text;
  const auto held = std::count_if(summary.requirements.begin(), summary.requirements.end(),
                                  [](const auto& one) { return one.status == RequirementOutcome::Status::holds; });
  return text + fmt::format("; {} of {} requirements hold", held, summary.requirements.size());
}

const char* requirement_status_name(RequirementOutcome::Status status) {
  switch (status) {
    case RequirementOutcome::Status::holds: return "holds";
    case RequirementOutcome::Status::violated: return "missed";
    case RequirementOutcome::Status::not_judged: return "not-judged";
    case RequirementOutcome::Status::invalid: return "wrong";
  }
  return "";
}

std::string requirement_title(const RequirementOutcome& one) {
  return one.run.empty() ? one.text : fmt::format("{} [{}]", one.text, one.run);
}

}  // namespace balance
