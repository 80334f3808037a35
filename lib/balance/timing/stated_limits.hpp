#pragma once
/// The limits that a trajectory states, as rows of a path. Private to timing.

#include "balance/timing/path_model.hpp"

#include <string>
#include <vector>

namespace balance {

/// Limits as given, several on one quantity all kept.
struct PathLimits {
  std::vector<LimitableQuantity> quantities;
  std::vector<double> half_widths, centres;  ///< half of the way between two limits, and what lies between them
};

/// What a name stands for. @throws std::invalid_argument if there is no such quantity
std::vector<LimitableQuantity> require_limited_quantities(const Mechanism& mechanism, const std::string& name);

/// @param what is searched for: "the law 'fastest'"
/// @throws std::invalid_argument if a load changes with time, so that what a place of the path needs depends on when
void require_constant_loads(const Mechanism& mechanism, const std::string& what);

/// @throws std::invalid_argument for limits that mean nothing, here or under the mechanism's loads. The message is fit for a user.
PathLimits collect_limits(const Mechanism& mechanism, const Trajectory& trajectory);

/// The path, its first rows those of the limits, each about its middle.
PathModel build_limited_path_model(const Mechanism& mechanism, const Trajectory& trajectory, const PathLimits& limits);

}  // namespace balance
