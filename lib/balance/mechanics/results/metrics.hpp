#pragma once
/// Peaks, averages and energy of a run.

#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/results/result.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace balance::results {

/// Samples that figures use in addition to the recorded ones: both sides of every jump of the acceleration and, if
/// recorded samples are few, times between them.
struct IntermediateSamples {
  RunResult rows;                 ///< times and all quantities, in order of time
  std::vector<long> next_sample;  ///< per row: the first sample at or after it

  /// Appends a row and returns its index. @param next first sample at or after the row
  long add(long next) {
    next_sample.push_back(next);
    return static_cast<long>(next_sample.size()) - 1;
  }
};

double statistic_of(const Metric& metric, Statistic statistic);

/// The metric of any values over time, without quantity and unit.
/// @param times one per value, ascending; both sides of a jump have the same time
Metric summarise_values(const std::vector<double>& values, const VectorX& times, double round_off);

/// Fills result.metrics and result.energy. Averages are over time, by the trapezoidal rule on all samples.
void add_metrics(RunResult& result, const IntermediateSamples& between);

/// Fills result.adaptation_moves, for the moves that the samples reach. Integrals as in add_metrics().
/// @param courses of a trajectory whose adaptations are modelled
void add_adaptation_moves(const Mechanism& mechanism, const std::vector<trajectory::CoordinateCourse>& courses,
                          const IntermediateSamples& between, RunResult& result);

/// A warning if the samples are too few for reliable figures: a joint turns by more than half a radian between two of
/// them, or a figure would change by more than 2 % without every second sample. Empty otherwise. Call after
/// add_metrics().
std::string check_sampling_density(const RunResult& result, const IntermediateSamples& between);

// Runs whose numbers overflow, so that their figures would be infinite or undefined.

/// The first time at which a quantity, or a figure computed from it, is not finite. @param result with metrics
std::optional<MotionOutcome> find_overflow(const RunResult& result, const IntermediateSamples& between,
                                           const Mechanism& mechanism);

// Quantities of a RunResult that have figures: peak, rms, mean, range.

/// Adjacent columns of one of RunResult's arrays that form a scalar or a vector.
struct MetricSeries {
  std::string quantity;  ///< "shaking_force", "torque[A1]"
  std::string unit;
  Samples RunResult::*array = nullptr;
  int first = 0, count = 1;
  std::string worst_group;  ///< "torque": the worst of adjacent series with this name has figures, too; empty: none
};

/// Series of all non-empty arrays; those of controlled runs come first.
std::vector<MetricSeries> list_metric_series(const RunResult& result);

/// Splits the series into ranges [first, last): adjacent series with the same worst_group, or single series.
std::vector<std::pair<std::size_t, std::size_t>> group_metric_series(const std::vector<MetricSeries>& all_series);

/// Names of all figures of a run along a trajectory; the worst of several figures comes before them.
std::vector<std::string> list_metric_names(const Mechanism& mechanism);

/// SI unit of the figures with that name: "N m"; empty if there are none.
std::string find_metric_unit(const Mechanism& mechanism, const std::string& name);

}  // namespace balance::results
