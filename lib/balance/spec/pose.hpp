#pragma once
/// Poses: `{tool: [x, y], angle: 0}`, `{joints: {J1: 0}}`, `{com: [x, y]}`.

#include "balance/spec/draft.hpp"

namespace balance::read {

/// At least one quantity. Keys: tool, joints, com; planar: angle; spatial: rpy or quaternion.
PoseTargetOf<Expression> read_pose(const Cursor& at, Draft& draft);

/// Which part of a pose a drive needs.
struct DriveNeeds {
  DriveKind drive = DriveKind::tool;
  std::vector<Component> components;  ///< empty: positions, and an orientation if the pose has one
};

/// Fails at `at` unless the pose has what the drive needs.
void check_pose(const Cursor& at, const PoseTargetOf<Expression>& pose, const DriveNeeds& needs, const Draft& draft);

/// A pose may be told in other quantities than the drive's: it is found, and the drive's are measured there.
bool told_otherwise(const PoseTargetOf<Expression>& pose, DriveKind drive);

/// Fails at `at` unless `pose` gives the same quantities as `model`; puts its joints into the model's order.
void match_pose(const Cursor& at, PoseTargetOf<Expression>& pose, const PoseTargetOf<Expression>& model,
                DriveKind drive, const Draft& draft);

}  // namespace balance::read
