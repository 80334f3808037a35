#pragma once
/// `momentum:` of what a task leaves open: the angular momentum that a quantity keeps.

#include "balance/spec/draft.hpp"

#include <optional>

namespace balance::read {

using KeptMomentumE = KeptMomentumOf<Expression>;

/// `zero`, a value, `{table: [[time, value], …]}` or `{file: momentum.csv}`. Where a spatial mechanism's component is not said it is
/// −1.
/// @param axis `axis: x`, if there is one
KeptMomentumE read_momentum(const Cursor& at, const std::optional<Cursor>& axis, Draft& draft);

/// Gives every component to one quantity. Fails if they do not match.
/// @param at `remaining`
void assign_components(const Cursor& at, const Draft& draft, TrajectoryOf<Expression>& trajectory);

}  // namespace balance::read
