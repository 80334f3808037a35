#pragma once
/// The fastest way along a path within limits.

#include "balance/motion/time_optimal/path_model.hpp"
#include "balance/motion/time_optimal/phase_plane_integration.hpp"

#include <string>
#include <vector>

namespace balance {

/// A moment of the law found: s'' and the row that limits it before and after.
struct TimeLawNode {
  double t = 0, s = 0, v = 0;
  double u_before = 0, u_after = 0;
  int row_after = -1;
};

struct TimeOptimalLaw {
  std::vector<TimeLawNode> nodes;    ///< from s = 0 to 1
  std::string infeasibility_reason;  ///< why there is none; empty: there is
  double duration() const { return nodes.back().t; }
};

/// s' at the path's ends.
struct EndpointRates {
  double start = 0, end = 0;
};

/// @param bounds one per row of the model
TimeOptimalLaw find_time_optimal_law(const PathModel& model, const std::vector<double>& bounds,
                                     const EndpointRates& rates);

/// Where rest is not allowed, by how much: "at 30 % of the path torque[A1] needs 45 N m at rest, 40 N m are allowed". Empty: it is.
std::string check_static_feasibility(const PathModel& model, const std::vector<double>& bounds);

// The fastest way along a leg by arcs at the edge of what the limits allow.

/// @param bounds one per row of the model
/// @return nodes from the leg's begin to its end, t from zero; or a refusal
TimeOptimalLaw integrate_phase_plane(const PathModel& model, const std::vector<double>& bounds, const SegmentRange& leg,
                                     const EndpointRates& rates);

/// The law with the least peak of a quantity in a duration.
struct MinPeakLaw {
  TimeOptimalLaw law;          ///< to be stretched to the duration
  double peak = 0;             ///< [SI]
  std::vector<double> bounds;  ///< that the law before stretching keeps, one per row of the model
};

/// @param limits of the model's first rows; the others are those whose peak is to be least @param duration [s]
MinPeakLaw find_min_peak_law(const PathModel& model, const std::vector<double>& limits, const EndpointRates& rates,
                             double duration);

// How well a law keeps its limits between its nodes.

/// Limits are kept to this part of them.
constexpr double limit_violation_tolerance = 1e-6;

/// Between two nodes, joined by a quintic. @return the worst load, as a part of its bound
double find_max_limit_ratio_between(const PathModel& model, const std::vector<double>& bounds,
                                    AccelerationLimits& allowed, const TimeLawNode& a, const TimeLawNode& b);

/// Between all nodes of a law.
double find_max_limit_ratio(const PathModel& model, const std::vector<double>& bounds, const TimeOptimalLaw& law);

// What is asked of a law that is searched for, and its search along one path.

/// Of the law fastest or gentlest: the limits, and behind their quantities those whose peak is to be least.
/// @throws std::invalid_argument if what the law needs is missing, or it cannot be found for this mechanism
PathLimits make_law_limits(const Mechanism& mechanism, const Trajectory& trajectory);

/// @param model of the task's quantities @return the law, or its refusal, with the peak reached if that is what is sought
MinPeakLaw find_motion_law(const PathModel& model, const PathLimits& task, const Trajectory& trajectory);

}  // namespace balance
