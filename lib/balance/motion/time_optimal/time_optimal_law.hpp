#pragma once
/// Time-optimal law along a path within limits.

#include "balance/motion/time_optimal/path_model.hpp"
#include "balance/motion/time_optimal/phase_plane_integration.hpp"

#include <string>
#include <vector>

namespace balance::time_optimal {

/// A node of the law: s'' on both sides and the active row after it.
struct TimeLawNode {
  double t = 0, s = 0, v = 0;
  double u_before = 0, u_after = 0;
  int row_after = -1;
};

struct TimeOptimalLaw {
  std::vector<TimeLawNode> nodes;    ///< from s = 0 to 1
  std::string infeasibility_reason;  ///< why there is none; empty if there is
  double duration() const { return nodes.back().t; }
};

/// s' at the ends of the path.
struct EndpointRates {
  double start = 0, end = 0;
};

/// @param bounds one per row of the model
TimeOptimalLaw find_time_optimal_law(const PathModel& model, const std::vector<double>& bounds,
                                     const EndpointRates& rates);

/// Where and by how much rest violates the limits: "at 30 % of the path torque[A1] needs 45 N m at rest, 5 N m more
/// than its limit". Empty if it does not.
std::string check_static_feasibility(const PathModel& model, const std::vector<double>& bounds);

// Time-optimal law of one leg by integration in the phase plane.

/// @param bounds one per row of the model
/// @return nodes from the beginning to the end of the leg, t from zero; or a reason for infeasibility
TimeOptimalLaw integrate_phase_plane(const PathModel& model, const std::vector<double>& bounds, const SegmentRange& leg,
                                     const EndpointRates& rates);

/// The law with the minimum peak of a quantity for a given duration.
struct MinPeakLaw {
  TimeOptimalLaw law;          ///< to be stretched to the duration
  double peak = 0;             ///< [SI]
  std::vector<double> bounds;  ///< that the law satisfies before stretching, one per row of the model
};

/// @param limits of the model's first rows; the peak of the others is minimised @param duration [s]
MinPeakLaw find_min_peak_law(const PathModel& model, const std::vector<double>& limits, const EndpointRates& rates,
                             double duration);

// Verification of limits between nodes.

/// Relative tolerance of limits.
constexpr double limit_violation_tolerance = 1e-6;

/// Between two nodes, joined by a quintic. @return the largest ratio of a magnitude to its bound
double find_max_limit_ratio_between(const PathModel& model, const std::vector<double>& bounds,
                                    AccelerationLimits& limits, const TimeLawNode& a, const TimeLawNode& b);

/// Between all nodes of a law.
double find_max_limit_ratio(const PathModel& model, const std::vector<double>& bounds, const TimeOptimalLaw& law);

// Requirements of optimised laws, and their search along one path.

/// For the laws fastest and gentlest: the limits, followed by the quantities whose peak is minimised.
/// @throws std::invalid_argument if something that the law needs is missing, or it cannot be found for this mechanism
PathLimits make_law_limits(const Mechanism& mechanism, const Trajectory& trajectory);

/// @param model of the quantities in `law_limits`
/// @return the law, or why there is none; with the peak if that is minimised
MinPeakLaw find_motion_law(const PathModel& model, const PathLimits& law_limits, const Trajectory& trajectory);

}  // namespace balance::time_optimal
