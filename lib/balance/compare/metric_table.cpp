#include "balance/compare/metric_table.hpp"

#include "balance/result/effort_names.hpp"

#include <algorithm>
#include <unordered_set>

namespace balance {
namespace {

/// The largest of each figure of `quantity[…]`, at the place of the first of them; nothing if it is there already.
void add_worst_case(MetricTable& table, const std::string& quantity) {
  std::vector<Metric>& metrics = table.metrics;
  if (find_metric(table, quantity) != nullptr) return;
  const auto is_part = [part = quantity + "["](const Metric& metric) { return metric.quantity.starts_with(part); };
  const auto first = std::find_if(metrics.begin(), metrics.end(), is_part);
  if (first == metrics.end()) return;
  Metric worst = *first;
  for (const Metric& metric : metrics) {
    if (!is_part(metric)) continue;
    if (metric.unit != worst.unit) return;  // the worst of forces and torques together would have no unit
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
  MetricTable table{std::move(name), result.metrics, result.energy};
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
  return exact != nullptr ? exact : find(to_force_name(std::string(quantity)));
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

}  // namespace balance
