#pragma once
/// How far a run and its figures are off when the numbers of a mechanism are: to first order, by exact derivatives, the numbers being
/// independent of each other. What vanishes at the numbers as the spec says them (a balanced force) has no slope but squares that are
/// known. docs/theory.md, section 11.

#include "balance/analysis/number_opening.hpp"
#include "balance/result/result.hpp"
#include "balance/study/design_space.hpp"
#include "balance/study/tolerances.hpp"

#include <string>
#include <vector>

namespace balance {

/// A figure as the spec has it, and how far it is off.
struct FigureDeviation {
  double value = 0;
  /// Standard deviation to first order. NaN where there is none: a magnitude that is not three times its own deviations has a kink
  /// within their reach.
  double deviation = 0;
  /// Per number its derivative times the number's deviation, whose squares add up to that of the deviation; NaN of those that open a joint.
  VectorX contributions;
  /// Times of the moments of which any may become the largest (or the least), if there are several and that matters: the deviation is then
  /// that of the largest of them, good to a hundredth, and by_number has averages. Empty where the figure has a slope.
  std::vector<double> extremum_times;
};

/// The sample that is off most.
struct WorstSample {
  long row = 0;
  double time = 0;       ///< [s]
  double value = 0;      ///< as the spec has it; of a vector its magnitude
  double deviation = 0;  ///< of a vector the root of the sum of its components' squares
  VectorX shares;        ///< per number its part of the squared deviation; they add up to 1
};

struct QuantityTolerance {
  std::string quantity;  ///< as in Metric, but for the worst of several
  std::string unit;
  FigureDeviation peak, rms, mean, range;
  /// Root of the expected mean square over the run, mean of f² + Σ (∂f/∂x σ)²: exact where f is linear in the numbers, as it is in masses,
  /// and to second order where it vanishes.
  double expected_rms = 0;
  double square_deviation = 0;  ///< of the mean square, in the same sense
  WorstSample worst;
};

struct ToleranceReport {
  MotionOutcome outcome;  ///< of the run; what follows is there if it is done
  Tolerances numbers;
  std::vector<IncompatibleParameter> incompatible_parameters;  ///< numbers that are left out of all deviations
  RunResult run;                                               ///< as the spec has it
  RunResult deviation;  ///< of every entry of the run's arrays: its standard deviation; orientations in space have none
  std::vector<QuantityTolerance> quantities;
  FigureDeviation energy;
};

/// So many samples times numbers are kept at most.
inline constexpr long max_tolerance_samples = 400'000;

/// @param space its start values are taken for the free numbers @param quantities "torque", "shaking_force[…]"; empty: all
/// @throws std::invalid_argument if there are no numbers or too many samples, or a trajectory whose law is searched for
ToleranceReport analyse_tolerance(const DesignSpace& space, const Tolerances& numbers, const Trajectory& trajectory,
                                  const std::vector<std::string>& quantities = {});

}  // namespace balance
