#pragma once
/// What of a Result has figures: peak, rms, mean, range.

#include "balance/model/mechanism.hpp"
#include "balance/result/result.hpp"

#include <string>
#include <utility>
#include <vector>

namespace balance {

/// Neighbouring columns of one of Result's arrays that together are a scalar or a vector.
struct MetricSeries {
  std::string quantity;  ///< "shaking_force", "torque[A1]"
  std::string unit;
  Samples RunResult::*array = nullptr;
  int first = 0, count = 1;
  std::string worst_group;  ///< "torque": the worst of the neighbours with this name has figures, too; empty: none has
};

/// Of every array that has columns; those of a run under control first.
std::vector<MetricSeries> list_metric_series(const RunResult& result);

/// The tracks in runs [first, last): neighbours that have a worst one together, every other by itself.
std::vector<std::pair<std::size_t, std::size_t>> group_metric_series(const std::vector<MetricSeries>& tracks);

/// Names of all figures of a run of a mechanism along a trajectory, the worst ones before those that they are the worst of.
std::vector<std::string> list_metric_names(const Mechanism& mechanism);

/// SI unit of a figure of that name: "N m"; empty if there is none of it.
std::string find_metric_unit(const Mechanism& mechanism, const std::string& name);

}  // namespace balance
