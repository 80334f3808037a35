#pragma once
/// Partly driven trajectories: `free`, `hold`, `initial`.

#include "balance/interface/specification/study_builder.hpp"

#include <optional>

namespace balance::specification {

/// Their values in a trajectory.
struct FreeMotionKeys {
  std::optional<SpecCursor> free, hold, initial;
};

/// Fills TrajectoryOf::free_motion, if any of the keys is given. The poses of the trajectory are known.
void read_free_motion(const FreeMotionKeys& keys, StudyBuilder& draft, TrajectoryOf<Expression>& trajectory);

}  // namespace balance::specification
