#include "balance/interface/comparison/comparison.hpp"

#include "balance/foundation/base/unicode_text.hpp"
#include "balance/interface/comparison/sample_difference.hpp"
#include "balance/mechanics/results/quantities.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <stdexcept>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <utility>

namespace balance::comparison {
namespace {

constexpr double zero_base_tolerance =
    1e-12;  ///< of a quantity's largest peak; smaller figures have no meaning of their own

/// Maps the name of each quantity to its first metric in a table.
using MetricIndex = std::unordered_map<std::string_view, const Metric*>;

std::vector<MetricIndex> index_metrics(const std::vector<MetricTable>& tables) {
  std::vector<MetricIndex> indices;
  for (const MetricTable& table : tables) {
    MetricIndex index;
    for (const Metric& metric : table.metrics) index.emplace(metric.quantity, &metric);
    indices.push_back(std::move(index));
  }
  return indices;
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
    const bool is_present = metric != nullptr && metric->unit == compared.unit;
    compared.metrics.push_back(is_present ? std::optional(*metric) : std::nullopt);
  }
  return compared;
}

void add_differences(ComparedRuns& compared, const std::vector<NamedRun>& runs) {
  for (std::size_t run = 1; run < runs.size(); ++run) {
    const auto list = list_differences(runs.front().result, runs[run].result);
    const std::map<std::string, Difference> differences(list.begin(), list.end());
    for (ComparedQuantity& quantity : compared.quantities) {
      const auto found = differences.find(quantity.quantity);
      const bool have_both = quantity.metrics.front() && quantity.metrics[run];
      if (have_both && found != differences.end()) quantity.differences[run] = found->second;
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
      note(fmt::format("{} and {}: differences are taken at the samples of the coarser, and the finer is interpolated",
                       base.result.time.size(), other.result.time.size()));
    }
    if (base.result.axes != other.result.axes) note("one is planar, one spatial: vectors are not compared");
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
  const double nan = std::numeric_limits<double>::quiet_NaN();
  if (!base || !metric) return nan;
  double largest = 0;
  for (const auto& run_metric : quantity.metrics)
    if (run_metric) largest = std::max(largest, run_metric->peak);
  if (!(statistic_of(*base, figure) > zero_base_tolerance * largest)) return nan;
  return statistic_of(*metric, figure) / statistic_of(*base, figure);
}

namespace {

/// Adds the maximum of each figure of `quantity[…]` before the first of them, unless `quantity` is there already.
void add_worst_case(MetricTable& table, const std::string& quantity) {
  std::vector<Metric>& metrics = table.metrics;
  if (find_metric(table, quantity) != nullptr) return;
  const auto is_part = [part = quantity + "["](const Metric& metric) { return metric.quantity.starts_with(part); };
  const auto first = std::find_if(metrics.begin(), metrics.end(), is_part);
  if (first == metrics.end()) return;
  Metric worst = *first;
  for (const Metric& metric : metrics) {
    if (!is_part(metric)) continue;
    if (metric.unit != worst.unit) return;  // a maximum over forces and torques would have no unit
    if (metric.peak > worst.peak) worst.peak = metric.peak, worst.peak_time = metric.peak_time;
    worst.rms = std::max(worst.rms, metric.rms);
    worst.mean = std::max(worst.mean, metric.mean);
    worst.range = std::max(worst.range, metric.range);
    worst.round_off = std::max(worst.round_off, metric.round_off);
  }
  worst.quantity = quantity;
  metrics.insert(first, worst);
}

}  // namespace

MetricTable make_metric_table(std::string name, const RunResult& result) {
  MetricTable table{std::move(name), result.metrics, result.energy, {}};
  for (const char* quantity : {"joint_force", "joint_moment"}) add_worst_case(table, quantity);
  return table;
}

const Metric* find_metric(const MetricTable& table, std::string_view quantity) {
  const auto find = [&](std::string_view name) {
    const auto found = std::find_if(table.metrics.begin(), table.metrics.end(),
                                    [&](const Metric& metric) { return metric.quantity == name; });
    return found == table.metrics.end() ? nullptr : &*found;
  };
  const Metric* exact = find(quantity);
  return exact != nullptr ? exact : find(results::to_force_name(std::string(quantity)));
}

const EvaluatedFigure* find_evaluated_figure(const MetricTable& table, std::string_view text) {
  const auto found = std::find_if(table.figures.begin(), table.figures.end(),
                                  [&](const EvaluatedFigure& figure) { return figure.text == text; });
  return found == table.figures.end() ? nullptr : &*found;
}

double find_figure(const MetricTable& table, Statistic figure, std::string_view quantity) {
  const Metric* metric = find_metric(table, quantity);
  return metric == nullptr ? std::numeric_limits<double>::quiet_NaN() : statistic_of(*metric, figure);
}

std::vector<std::string> list_quantity_names(const std::vector<MetricTable>& tables) {
  std::vector<std::string> names;
  std::unordered_set<std::string_view> known;
  for (const MetricTable& table : tables) {
    for (const Metric& metric : table.metrics) {
      if (known.insert(metric.quantity).second) names.push_back(metric.quantity);
    }
  }
  return names;
}

namespace {

/// Possible names, from the shortest to the longest.
std::vector<std::string> list_candidates(const RunLocation& location) {
  const std::filesystem::path path = std::filesystem::path(location.path).lexically_normal();
  const std::string stem = escape_for_terminal(path.stem().string());
  const std::string folder = escape_for_terminal(path.parent_path().filename().string());
  const std::string suffix = location.group.empty() ? "" : ":" + location.group;
  std::vector<std::string> names;
  if (!location.group.empty()) names.push_back(location.group);
  names.push_back(stem + suffix);
  if (!folder.empty()) names.push_back(folder + "/" + stem + suffix);
  names.push_back(escape_for_terminal((path.parent_path() / path.stem()).string()) + suffix);
  return names;
}

bool is_taken(const std::vector<std::string>& names, std::size_t run) {
  if (run > 0 && names[run] == "base") return true;
  return std::count(names.begin(), names.end(), names[run]) > 1;
}

}  // namespace

std::vector<std::string> make_run_names(const std::vector<RunLocation>& locations) {
  std::vector<std::vector<std::string>> candidates;
  std::vector<std::string> names;
  std::size_t max_candidates = 0;
  for (const RunLocation& location : locations) {
    candidates.push_back(list_candidates(location));
    names.push_back(candidates.back().front());
    max_candidates = std::max(max_candidates, candidates.back().size());
  }
  for (std::size_t length = 1; length < max_candidates; ++length) {
    std::vector<std::string> longer = names;
    for (std::size_t run = 0; run < names.size(); ++run) {
      if (is_taken(names, run)) longer[run] = candidates[run][std::min(length, candidates[run].size() - 1)];
    }
    names = longer;
  }
  for (std::size_t run = 1; run < names.size(); ++run) {
    const std::string name = names[run];
    for (std::size_t number = 2; is_taken(names, run); ++number) names[run] = name + "-" + std::to_string(number);
  }
  return names;
}

}  // namespace balance::comparison
