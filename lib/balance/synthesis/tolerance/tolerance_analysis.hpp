#pragma once
/// Deviations of a run and its figures if the numbers of a mechanism deviate: to first order, with exact derivatives
/// and independent numbers. Quantities that vanish at the nominal numbers (a balanced force) have no gradient, but
/// their expected squares are known. docs/theory.md, section 11.

#include "balance/mechanics/derivatives/mechanism_variables.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/results/result.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/motion/study/design_space.hpp"
#include "balance/motion/study/study.hpp"

#include <string>
#include <vector>

namespace balance::tolerance {

// Numbers that cannot deviate by themselves.

/// A number whose change over-constrained loops cannot follow. It is left out of all deviations.
struct IncompatibleParameter {
  std::size_t index = 0;  ///< among the tolerances
  std::string key_path;   ///< of the number
  std::string joint, unit;
  double gap = 0;  ///< maximum gap of the joint due to the deviation, minimised by moving all else [m or rad]
};

/// Appends the joints that a number opens.
/// @param number index among the tolerances
void add_incompatible_parameters(const derivatives::ClosureGaps& gaps, std::size_t number, const std::string& path,
                                 double deviation, const Mechanism& mechanism,
                                 std::vector<IncompatibleParameter>& incompatible_parameters);

/// The numbers that open no joint, with which mechanisms can be drawn.
/// @throws std::invalid_argument if every number opens a joint
Tolerances remove_incompatible_parameters(const Tolerances& numbers,
                                          const std::vector<IncompatibleParameter>& incompatible_parameters);

/// "… cannot follow ground.points.A[2] by itself: its deviation would open D by 0.0001 m".
std::string format_incompatibility_note(const IncompatibleParameter& parameter);

/// A figure with nominal numbers, and its deviation.
struct FigureDeviation {
  double value = 0;
  /// Standard deviation to first order. NaN if there is none: a magnitude below three times its own deviations has a
  /// kink within their reach.
  double deviation = 0;
  /// Per number, its derivative times the number's deviation; their squares add up to the squared deviation. NaN for
  /// numbers that open a joint.
  VectorX contributions;
  /// Instants any of which may become the maximum (or minimum), if there are several and that matters: the deviation is
  /// then that of the largest of them, accurate to a hundredth, and `contributions` are averages. Empty otherwise.
  std::vector<double> extremum_times;
};

/// The sample with the largest deviation.
struct WorstSample {
  long row = 0;
  double time = 0;       ///< [s]
  double value = 0;      ///< with nominal numbers; for a vector, its magnitude
  double deviation = 0;  ///< for a vector, the root of the sum of its components' squares
  VectorX shares;        ///< per number, its fraction of the squared deviation; they add up to 1
};

struct QuantityTolerance {
  std::string quantity;  ///< as in Metric, except for the worst of several
  std::string unit;
  FigureDeviation peak, rms, mean, range;
  /// Root of the expected mean square over the run, the mean of f² + Σ (∂f/∂x σ)²: exact if f is linear in the numbers,
  /// as it is in masses, and accurate to second order where f vanishes.
  double expected_rms = 0;
  double square_deviation = 0;  ///< standard deviation of the mean square, with the same accuracy
  WorstSample worst;
};

struct ToleranceReport {
  MotionOutcome outcome;  ///< of the run; the rest is valid if it is done
  Tolerances numbers;
  std::vector<IncompatibleParameter> incompatible_parameters;  ///< left out of all deviations
  RunResult run;                                               ///< with nominal numbers
  RunResult deviation;  ///< standard deviation of every entry of the run's arrays; spatial orientations have none
  std::vector<QuantityTolerance> quantities;
  FigureDeviation energy;
};

/// Maximum number of samples times numbers.
inline constexpr long max_tolerance_samples = 400'000;

/// @param space its start values stand for the free numbers
/// @param quantities "torque", "shaking_force[…]"; empty: all
/// @throws std::invalid_argument without numbers, with too many samples, or if the trajectory's law is to be optimised
ToleranceReport analyse_tolerance(const DesignSpace& space, const Tolerances& numbers, const Trajectory& trajectory,
                                  const std::vector<std::string>& quantities = {});

// Deviations of the efforts that hold a mechanism at rest, over its whole workspace.

/// The pose with the largest deviation of one actuator's effort at rest; the first pose if no number has any influence.
struct StaticDeviation {
  std::string actuator, unit;
  double deviation = 0;  ///< standard deviation to first order [N m or N]; exact for masses
  double effort = 0;     ///< there, with nominal numbers [N m or N]
  VectorX pose;          ///< of the independent coordinates [rad]
  VectorX shares;        ///< per number, its fraction of the squared deviation
};

struct StaticTolerance {
  MotionOutcome outcome;                 ///< not done if no pose could be reached and held: why the first one failed
  std::vector<std::string> coordinates;  ///< the independent coordinates
  std::vector<StaticDeviation> actuators;
  std::vector<IncompatibleParameter> incompatible_parameters;  ///< left out of all deviations
  long pose_count = 0, unreachable_count = 0;  ///< of the grid; poses that the mechanism cannot take are left out
};

/// Covers whole turns of the independent coordinates by a grid, refined around the worst of its poses. A maximum as
/// narrow as the grid's step may be missed.
/// @param steps per turn; 0: chosen by the number of coordinates
/// @throws std::invalid_argument if there are no numbers or no actuators, if an independent coordinate is a slide, or
/// if there would be more than 1e5 poses
StaticTolerance analyse_static_tolerance(const DesignSpace& space, const Tolerances& numbers, long steps = 0);

}  // namespace balance::tolerance
