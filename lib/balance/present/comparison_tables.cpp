#include "balance/present/comparison_tables.hpp"

#include "balance/base/plain_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace balance {
namespace {

const char* const missing = "-";

std::string cell(double value) { return std::isnan(value) ? missing : format_number(value); }
std::string ratio_cell(double ratio) { return std::isnan(ratio) ? missing : fmt::format("{:#.4g}", ratio); }

bool is_main(const std::string& quantity) {
  for (const char* name : {"torque", "power", "shaking_force", "shaking_moment", "joint_force", "joint_moment"}) {
    if (quantity == name) return true;
  }
  return quantity.starts_with("torque[") || quantity.starts_with("force[") || quantity.starts_with("power[");
}

bool is_shown(const ComparedQuantity& quantity, QuantitySelection shown) {
  return shown == QuantitySelection::all || is_main(quantity.quantity);
}

void add_column(TextTable& table, const std::string& heading, Align align) {
  table.heading.push_back(heading);
  table.align.push_back(align);
}

/// A name and its ratio to the base for every run but the base, which has no ratio.
void add_run_columns(TextTable& table, const ComparedRuns& compared) {
  for (std::size_t run = 0; run < compared.runs.size(); ++run) {
    add_column(table, compared.runs[run].name, Align::right);
    if (run > 0) add_column(table, "ratio", Align::right);
  }
}

TitledTextTable runs_table(const ComparedRuns& compared) {
  TextTable table;
  for (const char* heading : {"run", "file", "mechanism", "trajectory"}) add_column(table, heading, Align::left);
  for (const char* heading : {"duration [s]", "samples"}) add_column(table, heading, Align::right);
  for (const ComparedRuns::Run& run : compared.runs) {
    table.rows.push_back({run.name, escape_for_terminal(run.file), run.title,
                          fmt::format("{} ({}, drive {})", run.trajectory, run.law, run.drive),
                          fmt::format("{:.6g}", run.duration), std::to_string(run.samples)});
  }
  return {"runs; ratios and differences are to " + compared.runs.front().name, table};
}

TitledTextTable figure_table(const ComparedRuns& compared, Statistic figure, const char* title,
                             QuantitySelection shown) {
  TextTable table;
  for (const char* heading : {"quantity", "unit"}) add_column(table, heading, Align::left);
  add_run_columns(table, compared);
  for (const ComparedQuantity& quantity : compared.quantities) {
    if (!is_shown(quantity, shown)) continue;
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
  return base && base->peak > 0 ? format_percent(100 * value / base->peak) : missing;
}

TitledTextTable difference_table(const ComparedRuns& compared, QuantitySelection shown) {
  TextTable table;
  for (const char* heading : {"quantity", "unit"}) add_column(table, heading, Align::left);
  for (std::size_t run = 1; run < compared.runs.size(); ++run) {
    add_column(table, compared.runs[run].name, Align::right);
    for (const char* heading : {"of peak", "rms"}) add_column(table, heading, Align::right);
  }
  for (const ComparedQuantity& quantity : compared.quantities) {
    if (!is_shown(quantity, shown)) continue;
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

}  // namespace

std::vector<TitledTextTable> make_comparison_tables(const ComparedRuns& compared, QuantitySelection shown) {
  return {runs_table(compared),
          figure_table(compared, Statistic::peak, "peak", shown),
          figure_table(compared, Statistic::rms, "rms", shown),
          figure_table(compared, Statistic::mean, "mean", shown),
          figure_table(compared, Statistic::range, "range", shown),
          energy_table(compared),
          difference_table(compared, shown)};
}

TextTable verdict_table(const std::vector<RequirementVerdict>& verdicts) {
  TextTable table;
  for (const char* heading : {"", "requirement", "run", "outcome"}) add_column(table, heading, Align::left);
  for (const RequirementVerdict& verdict : verdicts) {
    table.rows.push_back(
        {verdict.holds ? "ok" : "FAILED", verdict.requirement, verdict.run, describe_verdict(verdict)});
  }
  return table;
}

std::string format_verdict_count(const std::vector<RequirementVerdict>& verdicts) {
  const auto holding =
      std::count_if(verdicts.begin(), verdicts.end(), [](const RequirementVerdict& one) { return one.holds; });
  return fmt::format("{} of {} requirement{} met", holding, verdicts.size(), verdicts.size() == 1 ? "" : "s");
}

}  // namespace balance
