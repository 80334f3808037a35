#pragma once
/// A whole run with its derivatives with respect to up to dual_width variables of the mechanism (inertial parameters,
/// lengths, angles, stiffnesses, ratios) and of the trajectory (poses, via points and their times, coefficients,
/// duration). Forward-mode differentiation with the implicit function theorem, accurate to round-off; see
/// docs/theory.md, section 10.

#include "balance/mechanics/derivatives/dual_evaluator.hpp"
#include "balance/mechanics/derivatives/mechanism_variables.hpp"
#include "balance/mechanics/results/metrics.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <array>
#include <string>
#include <vector>

namespace balance::derivatives {

struct RunGradient {
  RunResult run;  ///< as simulate() returns it, without metrics' round-off; valid only if its outcome is done
  results::IntermediateSamples intermediate;
  /// Per variable: derivatives of every entry of the run's arrays at a constant fraction of the duration, and of the
  /// times. Orientations (quaternions) have none.
  std::array<RunResult, numerics::dual_width> derivatives;
  std::array<results::IntermediateSamples, numerics::dual_width> derivatives_between;
  /// Per variable: if not empty, its derivatives are those of the least-squares solution of the loop closures.
  std::array<ClosureGaps, numerics::dual_width> closure_gaps;
};

/// @param mechanism, trajectory over dual numbers, seeded with the requested variables
/// @param quantities names of the arrays to compute ("torque", "shaking_moment", "joint_position"). Empty: all
///        arrays
/// @throws std::invalid_argument for fewer than two samples, or if the mechanism has constraints on rates
RunGradient differentiate_run(const MechanismOf<DualNumber>& mechanism, const TrajectoryOf<DualNumber>& trajectory,
                              const std::vector<std::string>& quantities = {});

/// The largest or smallest value within an interval of a run.
struct Extreme {
  double value = 0;
  std::array<double, numerics::dual_width> d{};
};

/// The figures of one quantity of a run, and their derivatives.
struct FigureGradient {
  std::string quantity;  ///< as in Metric
  double peak = 0, rms = 0, mean = 0, range = 0;
  std::array<double, numerics::dual_width> d_peak{}, d_rms{}, d_mean{}, d_range{};
  /// Per interval of the run: values that may become the peak, or an end of the range, when the variables change.
  std::vector<Extreme> highest, lowest;
};

struct FigureGradients {
  std::vector<FigureGradient> figures;  ///< of every series; taking the worst of several is left to the caller
  double energy = 0;                    ///< zero without an array of powers
  double duration = 0;
  std::array<double, numerics::dual_width> d_energy{}, d_duration{};
};

/// Peaks and ranges are differentiated at the rows where they currently occur. A magnitude of zero has zero
/// derivatives.
/// @param further series besides those of the run's metrics, which come first
FigureGradients differentiate_figures(const RunGradient& gradient,
                                      const std::vector<results::MetricSeries>& further = {});

}  // namespace balance::derivatives
