#pragma once
/// Peaks, averages and energy of a run.

#include "balance/result/figure.hpp"
#include "balance/result/result.hpp"

#include <string>
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

/// After add_metrics(): one sentence if there are too few places to rely on the figures: a joint turns by more than half a radian from one to the
/// next, or a figure would be another by more than 2 % without every second one. Empty otherwise.
std::string check_sampling_density(const RunResult& result, const IntermediateSamples& between);

}  // namespace balance
