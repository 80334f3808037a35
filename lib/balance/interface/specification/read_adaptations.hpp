#pragma once
/// Counterweights that move along their bodies during a trajectory: `adapt:`.

#include "balance/interface/specification/study_builder.hpp"

namespace balance::specification {

/// `{cw1: {to: [0.2, 0], start: 0.5, duration: 0.2}, cw2: [{…}, {…}]}`. Fills TrajectoryOf::adaptations. The law, the drive
/// and the duration of the trajectory are known.
void read_adaptations(const SpecCursor& at, StudyBuilder& draft, TrajectoryOf<Expression>& trajectory);

}  // namespace balance::specification
