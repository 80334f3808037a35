#pragma once
/// Peaks, averages and energy of a run.

#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/results/result.hpp"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace balance {

/// What figures count besides the samples: both sides of every jump of the acceleration, and the places between samples that
/// are few.
struct IntermediateSamples {
  RunResult rows;                 ///< times and all quantities, in the order of time
  std::vector<long> next_sample;  ///< per row: the first sample at or after it

  /// The row for the place to come. @param next the first sample at or after it
  long add(long next) {
    next_sample.push_back(next);
    return static_cast<long>(next_sample.size()) - 1;
  }
};

double statistic_of(const Metric& metric, Statistic figure);

/// Fills result.metrics and result.energy. Averages are over time, by the trapezoidal rule between all places.
void add_metrics(RunResult& result, const IntermediateSamples& between);

/// After add_metrics(): one sentence if there are too few places to rely on the figures: a joint turns by more than half a radian from one
/// to the next, or a figure would be another by more than 2 % without every second one. Empty otherwise.
std::string check_sampling_density(const RunResult& result, const IntermediateSamples& between);

// Runs whose numbers grew too large to be computed with: their figures would be infinite or undefined.

/// The first place where a quantity, or a figure made of it, is not finite. @param result with its metrics
std::optional<MotionOutcome> find_overflow(const RunResult& result, const IntermediateSamples& between,
                                           const Mechanism& mechanism);

// What of a RunResult has figures: peak, rms, mean, range.

/// Neighbouring columns of one of RunResult's arrays that together are a scalar or a vector.
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
