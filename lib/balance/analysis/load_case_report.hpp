#pragma once
/// What a design for several loads comes to, load by load.

#include "balance/conditions/remains.hpp"
#include "balance/design/adaptive_law.hpp"
#include "balance/result/result.hpp"
#include "balance/study/load_cases.hpp"

#include <optional>
#include <string>
#include <vector>

namespace balance {

/// One trajectory with one load.
struct LoadCaseRun {
  std::string trajectory;
  MotionOutcome outcome;
  std::vector<Metric> metrics;  ///< of torques, shaking force and shaking moment
};

struct LoadCaseReport {
  VectorX loads;        ///< values of LoadCases::numbers
  VectorX x;            ///< of the spec's free numbers with this load
  double residual = 0;  ///< largest scaled residual of the goal's conditions; without a goal 0
  std::vector<PeakEffort>
      static_efforts;  ///< of every actuator over random poses; those that carry nothing are left out
  std::vector<LoadCaseRun> runs;
};

/// Adapted numbers at single loads, where there is no formula.
struct AdaptedTable {
  std::vector<VectorX> loads, values;
  std::vector<double> residuals;  ///< largest scaled residual at each load
  double midpoint_residual =
      0;  ///< the same halfway between two loads, by the spline through the values; one number of the load only
};

struct AdaptiveReport {
  std::vector<int> numbers;        ///< places of the adapted numbers among the spec's free numbers
  std::optional<AdaptiveLaw> law;  ///< else there is a table
  AdaptedTable table;
  VectorX min_values, max_values;  ///< of every adapted number over the range of the loads
  bool is_within_bounds = true;    ///< the law keeps the bounds of the free numbers
  std::optional<double>
      adjustment_work;  ///< against gravity and springs, from the least to the largest loads, at the start of the first
                        ///< trajectory [J]; nothing where masses change or there is no trajectory
  std::vector<LoadCaseReport> fixed_design_cases;  ///< the cases with the numbers that suit the spec's own load
};

}  // namespace balance
