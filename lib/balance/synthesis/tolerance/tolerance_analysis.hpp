#pragma once
/// How far a run and its figures are off when the numbers of a mechanism are: to first order, by exact derivatives, the numbers being
/// independent of each other. What vanishes at the numbers as the spec says them (a balanced force) has no slope but squares that are
/// known. docs/theory.md, section 11.

#include "balance/mechanics/derivatives/mechanism_variables.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/results/result.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/motion/study/design_space.hpp"
#include "balance/motion/study/study.hpp"

#include <string>
#include <vector>

namespace balance {

// Numbers that no mechanism has off by themselves.

/// A number whose change over-constrained loops cannot follow. It has no part in any deviation.
struct IncompatibleParameter {
  std::size_t index = 0;  ///< among the tolerances
  std::string key_path;   ///< the number's
  std::string joint, unit;
  double gap =
      0;  ///< what the number's deviation opens the joint by where that is most, the rest being moved so that it is least [m or rad]
};

/// Adds what a number opens.
/// @param number index among the tolerances
void add_incompatible_parameters(const ClosureGaps& found, std::size_t number, const std::string& path,
                                 double deviation, const Mechanism& mechanism,
                                 std::vector<IncompatibleParameter>& openings);

/// The numbers that open nothing, of which mechanisms can be drawn.
/// @throws std::invalid_argument if every number opens a joint
Tolerances remove_incompatible_parameters(const Tolerances& numbers,
                                          const std::vector<IncompatibleParameter>& openings);

/// "… cannot follow ground.points.A[2] by itself: its deviation would open D by 0.0001 m".
std::string format_incompatibility_note(const IncompatibleParameter& opening);

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

// How far the efforts that hold a mechanism at rest are off, over its whole workspace.

/// The pose where one actuator's effort at rest is off most; the first one if no number has any influence.
struct StaticDeviation {
  std::string actuator, unit;
  double deviation = 0;  ///< standard deviation to first order [N m or N]; of masses exact
  double effort = 0;     ///< as the spec has it, there [N m or N]
  VectorX pose;          ///< of the independent coordinates [rad]
  VectorX shares;        ///< per number its part of the squared deviation
};

struct StaticTolerance {
  MotionOutcome outcome;                 ///< not done if no pose could be reached and held: why the first one could not
  std::vector<std::string> coordinates;  ///< the independent ones
  std::vector<StaticDeviation> actuators;
  std::vector<IncompatibleParameter> incompatible_parameters;  ///< numbers that are left out of all deviations
  long pose_count = 0, unreachable_count = 0;  ///< of the grid; those that the mechanism cannot take are left out
};

/// Over whole turns of the independent coordinates: a grid, refined about the worst of its poses. A maximum as narrow as the grid's step
/// may be missed.
/// @param steps per turn; chosen by the number of coordinates if 0
/// @throws std::invalid_argument if there are no numbers, no actuators, an independent coordinate is a slide or the poses would be more
/// than 1e5
StaticTolerance analyse_static_tolerance(const DesignSpace& space, const Tolerances& numbers, long steps = 0);

}  // namespace balance
