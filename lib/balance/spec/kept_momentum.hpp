#pragma once
/// `momentum:` of what a task leaves open: the angular momentum that a quantity keeps.

#include "balance/spec/draft.hpp"

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

}  // namespace balance::specification
