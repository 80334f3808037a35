#pragma once
/// Trajectories that follow a record of the machine: `measured: {file: log.csv}`.

#include "balance/interface/specification/study_builder.hpp"

namespace balance::specification {

/// Reads the record into the trajectory's path, poses, duration and samples, and its efforts into
/// Study::measured. The trajectory has its name; its drive becomes joints.
/// @param at the value of `measured`
void read_measured(const SpecCursor& at, StudyBuilder& draft, TrajectoryOf<Expression>& trajectory);

}  // namespace balance::specification
