#pragma once
/// A whole run with its derivatives with respect to up to dual_width numbers of the mechanism (inertial numbers, lengths, angles,
/// stiffnesses, ratios) and of the trajectory (poses, points and times on the way, coefficients, duration). Forward differentiation through
/// the implicit function theorem, good to round-off; see docs/theory.md, section 10.

#include "balance/mechanics/derivatives/dual_evaluator.hpp"
#include "balance/mechanics/derivatives/mechanism_variables.hpp"
#include "balance/mechanics/results/metrics.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <array>
#include <string>
#include <vector>

namespace balance {

struct RunGradient {
  RunResult run;  ///< as simulate() gives it, without metrics' round-off; its outcome says whether there is anything
  IntermediateSamples intermediate;
  /// Per number: what every entry of the run's arrays changes by at the same part of the duration, and the times themselves.
  /// Orientations have none (quaternions).
  std::array<RunResult, dual_width> derivatives;
  std::array<IntermediateSamples, dual_width> derivatives_between;
  /// Per number: where there are any, the number's derivatives are of what least squares leave.
  std::array<ClosureGaps, dual_width> closure_gaps;
};

/// @param mechanism, trajectory as numbers with derivatives, those of the numbers wanted set
/// @param quantities names of arrays that have figures ("torque", "shaking_moment"); no others are computed. Empty: all arrays
/// @throws std::invalid_argument for fewer than two samples
RunGradient differentiate_run(const MechanismOf<DualNumber>& mechanism, const TrajectoryOf<DualNumber>& trajectory,
                              const std::vector<std::string>& quantities = {});

/// The largest or least value in a stretch of a run.
struct Extreme {
  double value = 0;
  std::array<double, dual_width> d{};
};

/// A figure of a run and its derivatives.
struct FigureGradient {
  std::string quantity;  ///< as in Metric
  double peak = 0, rms = 0, mean = 0, range = 0;
  std::array<double, dual_width> d_peak{}, d_rms{}, d_mean{}, d_range{};
  /// Stretch by stretch of the run: what may become the peak, or an end of the range, with other numbers.
  std::vector<Extreme> highest, lowest;
};

struct FigureGradients {
  std::vector<FigureGradient> figures;  ///< of every track, worst ones left to the caller
  double energy = 0;                    ///< zero without an array of powers
  double duration = 0;
  std::array<double, dual_width> d_energy{}, d_duration{};
};

/// Peaks and ranges are differentiated at the places where they are now. A magnitude of zero has the derivative of zero.
FigureGradients differentiate_figures(const RunGradient& gradient);

}  // namespace balance
