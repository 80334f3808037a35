#pragma once
/// `remaining:` of a trajectory: what goes beside the tool or the centre of mass, and how.

#include "balance/spec/draft.hpp"

namespace balance::read {

/// `[J1, J2]`, or `{angle: {spline: …}, J1: {momentum: 0.02}, J2: line}`. Fills `remaining`, `remaining_angle` and `courses`.
void read_remaining(const Cursor& at, Draft& draft, TrajectoryOf<Expression>& trajectory);

/// The tool's angle goes as the angular momentum asks for.
bool keeps_momentum(const TrajectoryOf<Expression>& trajectory);

}  // namespace balance::read
