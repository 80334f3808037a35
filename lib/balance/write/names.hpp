#pragma once
/// What the spec language calls the program's kinds.

#include "balance/conditions/conditions.hpp"
#include "balance/design/solve.hpp"
#include "balance/motion/motion.hpp"
#include "balance/motion/trajectory.hpp"

#include <string>
#include <vector>

namespace balance {

const char* name_of(LawKind kind);         ///< "cycloidal", "bang-bang", …
const char* name_of(DriveKind kind);       ///< "joints", "tool", "com"
const char* name_of(MotionStatus status);  ///< "done", "drive-singularity", …

const char* name_of(ConditionsStatus status);  ///< "done", "rank-unclear", …
const char* name_of(DesignStatus status);      ///< "balanced", "compromise", …
const char* name_of(Optimality optimality);    ///< "proved-best", "local-best", …
const char* name_of(DesignMethod method);      ///< "affine", "polynomial", …

/// "static, force": the goals' names between commas.
std::string list_names(const std::vector<Goal>& goals);

/// What a goal means, as the end of a sentence: "the actuators carry no weight, whatever the configuration".
std::string in_words(const Goal& goal);

}  // namespace balance
