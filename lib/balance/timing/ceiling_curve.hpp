#pragma once
/// The largest rates that limits leave along a path. Private to timing.

#include "balance/motion/phase_plane.hpp"
#include "balance/timing/path_model.hpp"

#include <vector>

namespace balance {

/// Fills the ceiling of a phase plane.
/// @param bounds one per row of the model
void add_maximum_velocity_curve(const PathModel& model, const std::vector<double>& bounds, PhasePlane& plane);

}  // namespace balance
