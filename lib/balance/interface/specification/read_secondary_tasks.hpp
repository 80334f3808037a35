#pragma once
/// `momentum:` of what a task leaves open: the angular momentum that a quantity keeps.

#include "balance/interface/specification/study_builder.hpp"

#include <optional>

namespace balance::specification {

using KeptMomentumE = MomentumTaskOf<Expression>;

/// `zero`, a value, `{table: [[time, value], …]}` or `{file: momentum.csv}`. Where a spatial mechanism's component is not said it is
/// −1.
/// @param axis `axis: x`, if there is one
KeptMomentumE read_momentum_task(const SpecCursor& at, const std::optional<SpecCursor>& axis, StudyBuilder& draft);

/// Gives every component to one quantity. Fails if they do not match.
/// @param at `remaining`
void assign_momentum_components(const SpecCursor& at, const StudyBuilder& draft, TrajectoryOf<Expression>& trajectory);

// `remaining:` of a trajectory: what goes beside the tool or the centre of mass, and how.

/// `[J1, J2]`, or `{angle: {spline: …}, J1: {momentum: 0.02}, J2: line}`. Fills `remaining`, `remaining_angle` and `courses`.
void read_secondary_tasks(const SpecCursor& at, StudyBuilder& draft, TrajectoryOf<Expression>& trajectory);

/// The tool's angle goes as the angular momentum asks for.
bool has_momentum_task(const TrajectoryOf<Expression>& trajectory);

}  // namespace balance::specification
