#pragma once
/// Secondary tasks of a trajectory: `remaining:`, and in it `momentum:`, by which a coordinate
/// controls the angular momentum.

#include "balance/interface/specification/study_builder.hpp"

#include <optional>

namespace balance::specification {

using KeptMomentumE = trajectory::MomentumTaskOf<Expression>;

/// `zero`, a value, `{table: [[time, value], …]}` or `{file: momentum.csv}`. The axis is −1 if a spatial
/// mechanism's component is not given.
/// @param axis `axis: x`, if given
KeptMomentumE read_momentum_task(const SpecCursor& at, const std::optional<SpecCursor>& axis, StudyBuilder& draft);

/// Assigns every component to one quantity. Fails if they do not match.
/// @param at `remaining`
void assign_momentum_components(const SpecCursor& at, const StudyBuilder& draft, TrajectoryOf<Expression>& trajectory);

// `remaining:` of a trajectory: coordinates besides the tool or the centre of mass, and how they move.

/// `[J1, J2]`, or `{angle: {spline: …}, J1: {momentum: 0.02}, J2: line}`. Fills remaining_coordinates,
/// remaining_angle and secondary_tasks.
void read_secondary_tasks(const SpecCursor& at, StudyBuilder& draft, TrajectoryOf<Expression>& trajectory);

/// Whether the tool's angle follows from the angular momentum.
bool has_momentum_task(const TrajectoryOf<Expression>& trajectory);

}  // namespace balance::specification
