#pragma once
/// Writes a spec's mechanism as a model of simulators: MJCF (MuJoCo), SDF (Gazebo, Drake) or URDF.

#include "balance/motion/study/study.hpp"

#include <string>
#include <vector>

namespace balance::foreign {

enum class RobotFormat { mjcf, sdf, urdf };

/// That of a name (mjcf, sdf, urdf), or without one that of a file's suffix (.xml, .mjcf, .sdf, .world, .urdf).
/// @throws std::invalid_argument if neither says it; the message says what is expected
RobotFormat choose_robot_format(const std::string& name, const std::string& file);

/// "MJCF".
const char* name_of(RobotFormat format);

struct RobotExport {
  std::string text;                  ///< the file; it lists `notes` and `missing` in comments, too
  std::vector<std::string> notes;    ///< how the file says what it says
  std::vector<std::string> missing;  ///< what the format cannot express and the file lacks
};

/// Bodies with their counterweights, payloads and full inertias, joints, discs, gears, springs, dampers, friction,
/// motors, gravity. MJCF has loops as equality constraints, and stands at the start pose; SDF and URDF have the tree and
/// name the loops in comments.
/// @param trajectory whose start is the start pose; empty: the first one, or `assembly` if there is none
/// @throws study::UnknownNameError if there is no such trajectory; SpecError if the loops cannot be closed
RobotExport export_robot(const Study& study, RobotFormat format, const std::string& trajectory);

}  // namespace balance::foreign
