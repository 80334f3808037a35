#include "balance/compare/comparison.hpp"

#include "balance/compare/difference.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <string_view>
#include <unordered_map>
#include <utility>

namespace balance {
namespace {

constexpr double zero_base_tolerance =
    1e-12;  ///< of a quantity's largest peak: what is smaller has no meaning of its own

/// The first metric of every quantity's name in one table.
using MetricIndex = std::unordered_map<std::string_view, const Metric*>;

std::vector<MetricIndex> index_metrics(const std::vector<MetricTable>& tables) {
  std::vector<MetricIndex> all;
  for (const MetricTable& table : tables) {
    MetricIndex index;
    for (const Metric& metric : table.metrics) index.emplace(metric.quantity, &metric);
    all.push_back(std::move(index));
  }
  return all;
}

const Metric* find_metric(const MetricIndex& index, const std::string& quantity) {
  const auto found = index.find(quantity);
  return found == index.end() ? nullptr : found->second;
}

std::string unit_of(const std::string& quantity, const std::vector<MetricIndex>& tables) {
  for (const MetricIndex& table : tables) {
    if (const Metric* metric = find_metric(table, quantity)) return metric->unit;
  }
  return "";
}

ComparedQuantity compare_metrics(const std::string& quantity, const std::vector<MetricIndex>& tables) {
  ComparedQuantity compared{quantity, unit_of(quantity, tables), {}, {}};
  compared.differences.resize(tables.size());
  for (const MetricIndex& table : tables) {
    const Metric* metric = find_metric(table, quantity);
    const bool there = metric != nullptr && metric->unit == compared.unit;
    compared.metrics.push_back(there ? std::optional(*metric) : std::nullopt);
  }
  return compared;
}

void add_differences(ComparedRuns& compared, const std::vector<NamedRun>& runs) {
  for (std::size_t run = 1; run < runs.size(); ++run) {
    const auto list = list_differences(runs.front().result, runs[run].result);
    const std::map<std::string, Difference> differences(list.begin(), list.end());
    for (ComparedQuantity& quantity : compared.quantities) {
      const auto found = differences.find(quantity.quantity);
      const bool both = quantity.metrics.front() && quantity.metrics[run];
      if (both && found != differences.end()) quantity.differences[run] = found->second;
    }
  }
}

std::string sampling_of(const RunResult& result) {
  return fmt::format("{} samples over {:.6g} s", result.time.size(), duration_of(result));
}

void add_notes(ComparedRuns& compared, const std::vector<NamedRun>& runs) {
  const NamedRun& base = runs.front();
  for (std::size_t run = 1; run < runs.size(); ++run) {
    const NamedRun& other = runs[run];
    const auto note = [&](const std::string& text) {
      compared.notes.push_back(fmt::format("{} and {}: {}", base.name, other.name, text));
    };
    if (!have_equal_durations(base.result, other.result)) {
      note(fmt::format("{} and {}: differences are taken at equal fractions of the durations", sampling_of(base.result),
                       sampling_of(other.result)));
    } else if (base.result.time.size() != other.result.time.size()) {
      note(fmt::format("{} and {}: differences are taken at the samples of the coarser, the finer is interpolated",
                       base.result.time.size(), other.result.time.size()));
    }
    if (base.result.axes != other.result.axes) note("one is planar, one spatial: vectors have no differences");
    if (base.result.moment_reference != other.result.moment_reference) note("their moments are about different points");
  }
}

}  // namespace

std::vector<MetricTable> make_metric_tables(const std::vector<NamedRun>& runs) {
  std::vector<MetricTable> tables;
  for (const NamedRun& run : runs) tables.push_back(make_metric_table(run.name, run.result));
  return tables;
}

ComparedRuns compare_runs(const std::vector<NamedRun>& runs) {
  if (runs.empty()) throw std::invalid_argument("there are no runs to compare");
  ComparedRuns compared;
  for (const NamedRun& run : runs) {
    compared.runs.push_back({run.name, run.file, run.title, run.trajectory, run.law, run.drive,
                             static_cast<long>(run.result.time.size()), duration_of(run.result), run.result.energy});
  }
  const std::vector<MetricTable> tables = make_metric_tables(runs);
  const std::vector<MetricIndex> indices = index_metrics(tables);
  for (const std::string& quantity : list_quantity_names(tables))
    compared.quantities.push_back(compare_metrics(quantity, indices));
  add_differences(compared, runs);
  add_notes(compared, runs);
  return compared;
}

double ratio_to_base(const ComparedQuantity& quantity, std::size_t run, Statistic figure) {
  const auto& base = quantity.metrics.front();
  const auto& metric = quantity.metrics.at(run);
  const double missing = std::numeric_limits<double>::quiet_NaN();
  if (!base || !metric) return missing;
  double largest = 0;
  for (const auto& any : quantity.metrics)
    if (any) largest = std::max(largest, any->peak);
  if (!(statistic_of(*base, figure) > zero_base_tolerance * largest)) return missing;
  return statistic_of(*metric, figure) / statistic_of(*base, figure);
}

}  // namespace balance
