#pragma once
/// Poses: `{tool: [x, y], angle: 0}`, `{joints: {J1: 0}}`, `{com: [x, y]}`.

#include "balance/interface/specification/study_builder.hpp"

namespace balance::specification {

/// At least one quantity. Keys: tool, joints, com; planar: angle; spatial: rpy or quaternion.
trajectory::PoseTargetOf<Expression> read_pose(const SpecCursor& at, StudyBuilder& draft);

/// Parts of a pose that a drive needs.
struct DriveRequirements {
  DriveKind drive = DriveKind::tool;
  std::vector<trajectory::Component> components;  ///< empty: positions, and an orientation if the pose has one
};

/// Fails at `at` unless the pose has what the drive needs.
void check_pose(const SpecCursor& at, const trajectory::PoseTargetOf<Expression>& pose,
                const DriveRequirements& requirements, const StudyBuilder& draft);

/// Whether the pose is given in other quantities than the drive's: it is then found, and the
/// drive's are evaluated there.
bool overrides_pose(const trajectory::PoseTargetOf<Expression>& pose, DriveKind drive);

/// Fails at `at` unless `pose` gives the same quantities as `model`; puts its joints into the model's order.
void match_pose(const SpecCursor& at, trajectory::PoseTargetOf<Expression>& pose,
                const trajectory::PoseTargetOf<Expression>& model, DriveKind drive, const StudyBuilder& draft);

}  // namespace balance::specification
