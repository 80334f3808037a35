#pragma once
/// What the spec language calls laws, drives and the ways a motion ends.

#include "balance/motion/motion.hpp"
#include "balance/motion/trajectory.hpp"

namespace balance {

const char* name_of(MotionLawKind kind);  ///< "cycloidal", "bang-bang", …
/// Of what leads a trajectory through time: its law, or "table".
const char* law_name(const Trajectory& trajectory);
const char* name_of(DriveKind kind);       ///< "joints", "tool", "com"
const char* name_of(MotionStatus status);  ///< "done", "drive-singularity", …

}  // namespace balance
