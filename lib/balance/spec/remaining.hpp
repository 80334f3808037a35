#pragma once
/// `remaining:` of a trajectory: what goes beside the tool or the centre of mass, and how.

#include "balance/spec/draft.hpp"

namespace balance::specification {

/// `[J1, J2]`, or `{angle: {spline: …}, J1: {momentum: 0.02}, J2: line}`. Fills `remaining`, `remaining_angle` and `courses`.
void read_secondary_tasks(const SpecCursor& at, StudyBuilder& draft, TrajectoryOf<Expression>& trajectory);

/// The tool's angle goes as the angular momentum asks for.
bool has_momentum_task(const TrajectoryOf<Expression>& trajectory);

}  // namespace balance::specification
