#include "balance/interface/reports/comparison_sections.hpp"

#include "balance/foundation/base/unicode_text.hpp"
#include "balance/interface/files/report_fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

namespace balance::reports {

using comparison::ComparedQuantity;
using comparison::ComparedRuns;
using comparison::RequirementVerdict;
using files::Align;
using files::TextTable;

namespace {

constexpr std::array<std::pair<Statistic, const char*>, 4> statistics{
    {{Statistic::peak, "peak"}, {Statistic::rms, "rms"}, {Statistic::mean, "mean"}, {Statistic::range, "range"}}};

const ReportFields<ComparedRuns::Run>& run_fields() {
  using Row = ComparedRuns::Run;
  static const ReportFields<Row> fields{
      {&Row::name, JsonKey{"name"}, TextColumn{"run"}},
      {&Row::file, JsonKey{"file"}, TextColumn{},
       [](const Row& run, const files::DisplayUnit&) { return escape_for_terminal(run.file); }},
      {&Row::title, JsonKey{"mechanism"}, TextColumn{}},
      {&Row::trajectory, JsonKey{"trajectory"}, TextColumn{},
       [](const Row& run, const files::DisplayUnit&) {
         return fmt::format("{} ({}, drive {})", run.trajectory, run.law, run.drive);
       }},
      {&Row::law, JsonKey{"law"}},
      {&Row::drive, JsonKey{"drive"}},
      {&Row::duration, JsonKey{"duration"}, TextColumn{"duration", "{:.6g}"}, SiUnit{"s"}},
      {&Row::samples, JsonKey{"samples"}, TextColumn{}},
      {&Row::energy, JsonKey{"energy"}}};
  return fields;
}

Json difference_json(const std::optional<comparison::Difference>& difference) {
  if (!difference) return nullptr;
  return {{"largest", difference->largest}, {"time", difference->time}, {"rms", difference->rms}};
}

Json metric_of_run_json(const ComparedQuantity& quantity, std::size_t run) {
  const auto& metric = quantity.metrics[run];
  if (!metric) return nullptr;
  Json json = files::metrics_json({*metric}).front();
  json.erase("quantity");
  json.erase("unit");
  if (run == 0) return json;
  for (const auto& [statistic, name] : statistics) json["ratio"][name] = ratio_to_base(quantity, run, statistic);
  json["difference"] = difference_json(quantity.differences[run]);
  return json;
}

Json quantity_json(const ComparedQuantity& quantity, const ComparedRuns& compared) {
  Json json = {{"quantity", quantity.quantity}, {"unit", quantity.unit}, {"runs", Json::object()}};
  for (std::size_t run = 0; run < compared.runs.size(); ++run)
    json["runs"][compared.runs[run].name] = metric_of_run_json(quantity, run);
  return json;
}

Json judged_json(const comparison::JudgedComparison& judged) {
  return {{"left_text", judged.left_text},
          {"relation", relation_symbol(judged.relation)},
          {"right_text", judged.right_text},
          {"left", judged.left},
          {"right", judged.right},
          {"unit", judged.unit},
          {"holds", judged.holds()},
          {"margin", judged.margin()},
          {"margin_percent", judged.margin_percent()}};
}

const ReportFields<RequirementVerdict>& verdict_fields() {
  using Row = RequirementVerdict;
  static const ReportFields<Row> fields{
      {[](const Row& verdict) { return verdict.holds ? "ok" : "FAILED"; }, TextColumn{""}},
      {&Row::requirement, JsonKey{"requirement"}, TextColumn{}},
      {[](const Row& verdict) { return files::text_or_null(verdict.run); }, JsonKey{"run"}, TextColumn{}},
      {&Row::holds, JsonKey{"holds"}},
      {comparison::describe_verdict, JsonKey{"outcome"}, TextColumn{}},
      {[](const Row& verdict) { return files::list_json(verdict.compared, judged_json); }, JsonKey{"comparisons"}},
      {&Row::missing, JsonKey{"missing"}}};
  return fields;
}

}  // namespace

std::string comparison_json(const ComparedRuns& compared, const std::vector<RequirementVerdict>& verdicts) {
  Json json = {{"base", compared.runs.front().name}};
  json["runs"] = rows_json(compared.runs, run_fields());
  json["quantities"] = Json::array();
  for (const ComparedQuantity& quantity : compared.quantities)
    json["quantities"].push_back(quantity_json(quantity, compared));
  json["notes"] = compared.notes;
  json["requirements"] = rows_json(verdicts, verdict_fields());
  json["all_hold"] = do_all_hold(verdicts);
  return files::format_json(json);
}

JunitSuite make_verdict_suite(const std::string& name, const std::vector<RequirementVerdict>& verdicts) {
  JunitSuite suite{name, {}};
  for (const RequirementVerdict& verdict : verdicts) {
    JunitCase junit_case;
    junit_case.group = verdict.run.empty() ? name : verdict.run;
    junit_case.name = verdict.requirement;
    if (verdict.holds) {
      junit_case.output = describe_verdict(verdict);
    } else {
      junit_case.status = JunitCase::Status::failed;
      junit_case.kind = "requirement";
      junit_case.message = describe_verdict(verdict);
      for (const comparison::JudgedComparison& judged : verdict.compared) {
        junit_case.details +=
            fmt::format("{} = {:.17g}\n{} = {:.17g}\n", judged.left_text, judged.left, judged.right_text, judged.right);
      }
    }
    suite.cases.push_back(std::move(junit_case));
  }
  return suite;
}

namespace {

struct TitledTextTable {
  std::string title;
  TextTable table;
};

const char* const missing = "-";

std::string cell(double value) { return std::isnan(value) ? missing : files::format_number(value); }
std::string ratio_cell(double ratio) { return std::isnan(ratio) ? missing : fmt::format("{:#.4g}", ratio); }

bool is_main_quantity(const std::string& quantity) {
  for (const char* name : {"torque", "power", "shaking_force", "shaking_moment", "joint_force", "joint_moment"}) {
    if (quantity == name) return true;
  }
  return quantity.starts_with("torque[") || quantity.starts_with("force[") || quantity.starts_with("power[");
}

bool is_shown(const ComparedQuantity& quantity, QuantitySelection selection) {
  return selection == QuantitySelection::all || is_main_quantity(quantity.quantity);
}

void add_column(TextTable& table, const std::string& heading, Align align) {
  table.heading.push_back(heading);
  table.align.push_back(align);
}

/// One column per run, followed by its ratio to the base for all runs but the base. The base is repeated where the
/// table is split.
void add_run_columns(TextTable& table, const ComparedRuns& compared) {
  table.key_columns = table.heading.size() + 1;
  for (std::size_t run = 0; run < compared.runs.size(); ++run) {
    if (run > 0) table.blocks.push_back(table.heading.size());
    add_column(table, compared.runs[run].name, Align::right);
    if (run > 0) add_column(table, "ratio", Align::right);
  }
}

TitledTextTable figure_table(const ComparedRuns& compared, Statistic figure, const char* title,
                             QuantitySelection selection) {
  TextTable table;
  for (const char* heading : {"quantity", "unit"}) add_column(table, heading, Align::left);
  add_run_columns(table, compared);
  for (const ComparedQuantity& quantity : compared.quantities) {
    if (!is_shown(quantity, selection)) continue;
    std::vector<std::string> row = {quantity.quantity, quantity.unit};
    for (std::size_t run = 0; run < compared.runs.size(); ++run) {
      const auto& metric = quantity.metrics[run];
      row.push_back(metric ? cell(statistic_of(*metric, figure)) : missing);
      if (run > 0) row.push_back(ratio_cell(ratio_to_base(quantity, run, figure)));
    }
    table.rows.push_back(std::move(row));
  }
  return {title, table};
}

std::string percent_of_peak(const ComparedQuantity& quantity, double value) {
  const auto& base = quantity.metrics.front();
  return base && base->peak > 0 ? comparison::format_percent(100 * value / base->peak) : missing;
}

TitledTextTable difference_table(const ComparedRuns& compared, QuantitySelection selection) {
  TextTable table;
  for (const char* heading : {"quantity", "unit"}) add_column(table, heading, Align::left);
  table.key_columns = table.heading.size();
  for (std::size_t run = 1; run < compared.runs.size(); ++run) {
    table.blocks.push_back(table.heading.size());
    add_column(table, compared.runs[run].name, Align::right);
    for (const char* heading : {"of peak", "rms"}) add_column(table, heading, Align::right);
  }
  for (const ComparedQuantity& quantity : compared.quantities) {
    if (!is_shown(quantity, selection)) continue;
    std::vector<std::string> row = {quantity.quantity, quantity.unit};
    for (std::size_t run = 1; run < compared.runs.size(); ++run) {
      const auto& difference = quantity.differences[run];
      row.push_back(difference ? cell(difference->largest) : missing);
      row.push_back(difference ? percent_of_peak(quantity, difference->largest) : missing);
      row.push_back(difference ? cell(difference->rms) : missing);
    }
    table.rows.push_back(std::move(row));
  }
  return {"largest difference at the same time", table};
}

TitledTextTable energy_table(const ComparedRuns& compared) {
  TextTable table;
  for (const char* heading : {"quantity", "unit"}) add_column(table, heading, Align::left);
  add_run_columns(table, compared);
  const double base = compared.runs.front().energy;
  std::vector<std::string> row = {"energy", "J"};
  for (std::size_t run = 0; run < compared.runs.size(); ++run) {
    const double energy = compared.runs[run].energy;
    row.push_back(cell(energy));
    if (run > 0) row.push_back(base == 0 ? missing : ratio_cell(energy / base));
  }
  table.rows.push_back(std::move(row));
  return {"moved by the actuators", table};
}

/// The runs; for each figure every quantity with its ratio to the base; the energy; the differences.
std::vector<TitledTextTable> make_comparison_tables(const ComparedRuns& compared, QuantitySelection selection) {
  std::vector<TitledTextTable> tables{{"runs; ratios and differences are relative to " + compared.runs.front().name,
                                       rows_table(compared.runs, run_fields())}};
  for (const auto& [statistic, name] : statistics) tables.push_back(figure_table(compared, statistic, name, selection));
  tables.push_back(energy_table(compared));
  tables.push_back(difference_table(compared, selection));
  return tables;
}

/// "3 of 4 requirements met"
std::string format_verdict_count(const std::vector<RequirementVerdict>& verdicts) {
  const auto met_count =
      std::count_if(verdicts.begin(), verdicts.end(), [](const RequirementVerdict& one) { return one.holds; });
  return fmt::format("{} of {} requirement{} met", met_count, verdicts.size(), verdicts.size() == 1 ? "" : "s");
}

std::string format_csv_number(double value) { return std::isfinite(value) ? fmt::format("{:.17g}", value) : ""; }

class CsvRows {
 public:
  explicit CsvRows(const ComparedRuns& compared) : compared_(compared) {}

  void add(const std::string& quantity, const std::string& unit, const char* figure, std::size_t run, double value,
           double ratio = NAN) {
    text_ += fmt::format("{},{},{},{},{},{}\n", files::escape_csv_field(quantity), files::escape_csv_field(unit),
                         figure, files::escape_csv_field(compared_.runs[run].name), format_csv_number(value),
                         format_csv_number(ratio));
  }

  void add(const ComparedQuantity& q, std::size_t run) {
    const auto& metric = q.metrics[run];
    for (const auto& [statistic, name] : statistics)
      add(q.quantity, q.unit, name, run, metric ? statistic_of(*metric, statistic) : NAN,
          ratio_to_base(q, run, statistic));
    add(q.quantity, "s", "peak_time", run, metric ? metric->peak_time : NAN);
    if (run == 0) return;
    const std::optional<comparison::Difference>& difference = q.differences[run];
    add(q.quantity, q.unit, "largest_difference", run, difference ? difference->largest : NAN);
    add(q.quantity, "s", "difference_time", run, difference ? difference->time : NAN);
    add(q.quantity, q.unit, "rms_difference", run, difference ? difference->rms : NAN);
  }

  const std::string& text() const { return text_; }

 private:
  const ComparedRuns& compared_;
  std::string text_ = "quantity,unit,figure,run,value,ratio\n";
};

}  // namespace

std::string format_verdict_line(const RequirementVerdict& verdict) {
  return escape_for_terminal(fmt::format("{:<6} {}{}{}{}: {}", verdict.holds ? "ok" : "FAILED", verdict.requirement,
                                         verdict.run.empty() ? "" : " [", verdict.run, verdict.run.empty() ? "" : "]",
                                         describe_verdict(verdict)));
}

std::string format_verdicts(const std::vector<RequirementVerdict>& verdicts) {
  std::string text;
  for (const RequirementVerdict& verdict : verdicts) text += format_verdict_line(verdict) + "\n";
  return text;
}

std::string comparison_text(const ComparedRuns& compared, const std::vector<RequirementVerdict>& verdicts,
                            QuantitySelection selection, std::size_t width) {
  std::string text;
  for (const TitledTextTable& table : make_comparison_tables(compared, selection)) {
    text += files::wrap_lines(table.title, width) + "\n\n" + format_table(table.table, width) + "\n";
  }
  for (const std::string& note : compared.notes)
    text += files::wrap_lines("note: " + escape_for_terminal(note), width) + "\n";
  if (!compared.notes.empty() && !verdicts.empty()) text += "\n";
  if (!verdicts.empty()) text += format_verdicts(verdicts) + "\n" + format_verdict_count(verdicts) + "\n";
  if (text.ends_with("\n\n")) text.pop_back();
  return text;
}

std::string comparison_markdown(const ComparedRuns& compared, const std::vector<RequirementVerdict>& verdicts,
                                QuantitySelection selection) {
  std::string text = "# Comparison with " + files::escape_markdown(compared.runs.front().name) + "\n";
  if (!verdicts.empty()) {
    constexpr std::size_t requirement = 1;
    text += "\n## Requirements\n\n" + format_verdict_count(verdicts) + ".\n\n" +
            files::format_markdown_table(rows_table(verdicts, verdict_fields()), {requirement});
  }
  for (const TitledTextTable& table : make_comparison_tables(compared, selection)) {
    std::string title = table.title;
    title[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(title[0])));
    text += "\n## " + files::escape_markdown(title) + "\n\n" + format_markdown_table(table.table);
  }
  for (const std::string& note : compared.notes) text += "\nNote: " + files::escape_markdown(note) + "\n";
  return text;
}

std::string comparison_csv(const ComparedRuns& compared) {
  CsvRows rows(compared);
  for (const ComparedQuantity& quantity : compared.quantities) {
    for (std::size_t run = 0; run < compared.runs.size(); ++run) rows.add(quantity, run);
  }
  const double base = compared.runs.front().energy;
  for (std::size_t run = 0; run < compared.runs.size(); ++run) {
    const double energy = compared.runs[run].energy;
    rows.add("energy", "J", "total", run, energy, base == 0 ? NAN : energy / base);
  }
  return rows.text();
}

}  // namespace balance::reports
