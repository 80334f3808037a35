#pragma once
/// Loops that are said apart from a tree: which two frames meet, and how.

#include "balance/import/robot.hpp"

#include <string>

namespace balance::foreign {

/// A frame fixed to a body.
struct BodyFrame {
  int body = 0;
  Pose pose;  ///< in the body
};

/// Adds the joint that lets the second frame move against the first; at zero they coincide.
/// @param axis in the frames' axes; unit
void add_loop_joint(ForeignModel& robot, const std::string& name, JointType type, const BodyFrame& first,
                    const BodyFrame& second, const Vector3& axis, const SourceLocation& place);

/// Poses of all bodies in bodies[0] when every joint of the tree is at zero; closures are not looked at.
std::vector<Pose> zero_configuration_poses(const ForeignModel& robot);

/// A Gepetto loop file: `closed_loop: [[A, B], …]` names frames (a joint's is its child's), `type: [6d, 3d]` how they meet,
/// `name_mot: […]` the driven joints.
/// @throws SpecError with everything that is wrong
void read_gepetto_loops(const std::string& text, const std::string& file, ForeignModel& robot);

/// Bodies without anything on them that only mark where a closure is, carried by the joint that the closure names: they lose
/// their mass. Told.
void clear_marker_masses(ForeignModel& robot, const std::vector<int>& named_bodies);

}  // namespace balance::foreign
