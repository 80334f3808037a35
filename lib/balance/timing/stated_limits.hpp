#pragma once
/// The limits that a trajectory states, as rows of a path. Private to timing.

#include "balance/timing/path_model.hpp"

#include <string>
#include <vector>

namespace balance {

/// Limits as given, several on one quantity all kept.
struct StatedLimits {
  std::vector<LimitedQuantity> quantities;
  std::vector<double> bounds, middles;  ///< half of the way between two limits, and what lies between them
};

/// What a name stands for. @throws std::invalid_argument if there is no such quantity
std::vector<LimitedQuantity> find_or_throw(const Mechanism& mechanism, const std::string& name);

/// @param what is searched for: "the law 'fastest'"
/// @throws std::invalid_argument if a load changes with time, so that what a place of the path needs depends on when
void refuse_changing_loads(const Mechanism& mechanism, const std::string& what);

/// @throws std::invalid_argument for limits that mean nothing, here or under the mechanism's loads. The message is fit for a user.
StatedLimits list_limits(const Mechanism& mechanism, const Trajectory& trajectory);

/// The path, its first rows those of the limits, each about its middle.
PathModel model_limits(const Mechanism& mechanism, const Trajectory& trajectory, const StatedLimits& limits);

}  // namespace balance
