#pragma once
/// The fastest way along a path within limits. Private to timing.

#include "balance/timing/controllable.hpp"

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

}  // namespace balance
