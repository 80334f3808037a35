#pragma once
/// Where a spec states something, for mistakes that show only when it is used.

#include "balance/foundation/base/error.hpp"
#include "balance/motion/study/study.hpp"

#include <string>

namespace balance::specification {

/// The place of a key path, `controllers.slow.kp`, or of the longest part of it that the spec has; its line is 0 if the
/// spec has nothing of it, as a built-in controller. Parts of a spec are searched in their own files.
/// @return with the whole path as key
SourceLocation locate_key(const Study& study, const std::string& key);

/// Of a trajectory that does not go with the mechanism: its `free`, `from` or `speed`, else the whole.
SourceLocation locate_trajectory(const Study& study, const Trajectory& trajectory);

}  // namespace balance::specification
