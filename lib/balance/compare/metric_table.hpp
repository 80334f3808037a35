#pragma once
/// The figures of one run under the name that comparisons and requirements call it by.

#include "balance/result/figure.hpp"
#include "balance/result/metrics.hpp"

#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace balance {

struct MetricTable {
  std::string name;             ///< of the run: a file's stem, a case of a suite
  std::vector<Metric> metrics;  ///< SI; a quantity that is not there is missing in this run
  double energy = std::numeric_limits<double>::quiet_NaN();  ///< as Result::energy [J]; NaN: missing
};

/// The run's own metrics and, behind those of the joints, the worst reaction of all: `joint_force`, `joint_moment`.
MetricTable make_metric_table(std::string name, const RunResult& result);

/// Null if the run has no such quantity. A slide's force is found by its older name, `torque[S]`, too.
const Metric* find_metric(const MetricTable& table, std::string_view quantity);

/// NaN if the run has no such quantity.
double find_figure(const MetricTable& table, Statistic figure, std::string_view quantity);

/// Every quantity that at least one of the runs has, in the order in which they first appear.
std::vector<std::string> list_quantity_names(const std::vector<MetricTable>& tables);

}  // namespace balance
