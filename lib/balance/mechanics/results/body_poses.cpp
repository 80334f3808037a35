#include "balance/mechanics/results/body_poses.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/rotation.hpp"
#include "balance/mechanics/results/round_off.hpp"

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace balance {
namespace {

/// Pose of a body in the world.
struct WorldFrame {
  Matrix3 rotation = Matrix3::Identity();
  Vector3 origin = Vector3::Zero();
};

/// Displacement by a joint's coordinates: from its point on the first body to that on the second, and the rotation,
/// both in the first body's axes.
struct Displacement {
  Matrix3 rotation = Matrix3::Identity();
  Vector3 translation = Vector3::Zero();
};

Displacement displace(const Joint& joint, const double* q) {
  const Vector3& u = joint.axis;
  switch (joint.type) {
    case JointType::fixed: return {};
    case JointType::revolute: return {rotation_about(u, q[0]), Vector3::Zero()};
    case JointType::prismatic: return {Matrix3::Identity(), q[0] * u};
    case JointType::pin_slot: return {rotation_about(Vector3::UnitZ(), q[1]), q[0] * u};
    case JointType::cylindrical: return {rotation_about(u, q[0]), q[1] * u};
    case JointType::universal: return {rotation_about(u, q[0]) * rotation_about(joint.axis2, q[1]), Vector3::Zero()};
    case JointType::spherical:
      return {rotation_about(Vector3::UnitX(), q[0]) * rotation_about(Vector3::UnitY(), q[1]) *
                  rotation_about(Vector3::UnitZ(), q[2]),
              Vector3::Zero()};
    case JointType::planar: return {rotation_about(u, q[2]), q[0] * joint.axis2 + q[1] * u.cross(joint.axis2)};
    case JointType::rolling_disc: {
      const Vector3 v = joint.axis2, w = u.cross(v);
      const Matrix3 leaning = rotation_about(u, q[2]) * rotation_about(v, q[3]);
      return {leaning * rotation_about(w, q[4]), q[0] * v + q[1] * w + leaning * (joint.radius * u)};
    }
    case JointType::rolling_sphere:
      return {rotation_about(Vector3::UnitX(), q[2]) * rotation_about(Vector3::UnitY(), q[3]) *
                  rotation_about(Vector3::UnitZ(), q[4]),
              q[0] * joint.axis2 + q[1] * u.cross(joint.axis2) + joint.radius * u};
  }
  return {};
}

/// A joint on the path from the ground to a body.
struct TreeStep {
  JointId joint = 0;
  bool forward = true;  ///< towards the joint's second body
  Eigen::Index first_coordinate = 0;
};

/// Joints that reach every body, nearest to the ground first. All coordinates of a run are known, so any tree will do.
std::vector<TreeStep> steps_from_ground(const Mechanism& mechanism) {
  std::vector<Eigen::Index> first;
  Eigen::Index count = 0;
  for (const Joint& joint : mechanism.joints) {
    first.push_back(count);
    count += joint_degrees_of_freedom(joint.type);
  }
  std::vector<bool> is_reached(mechanism.bodies.size(), false);
  is_reached[ground] = true;
  std::vector<TreeStep> steps;
  for (bool has_grown = true; has_grown;) {
    has_grown = false;
    const std::vector<bool> was_reached = is_reached;
    for (std::size_t j = 0; j < mechanism.joints.size(); ++j) {
      const auto a = static_cast<std::size_t>(mechanism.joints[j].first);
      const auto b = static_cast<std::size_t>(mechanism.joints[j].second);
      const bool forward = was_reached[a] && !is_reached[b], backward = was_reached[b] && !is_reached[a];
      if (!forward && !backward) continue;
      is_reached[forward ? b : a] = true;
      steps.push_back({static_cast<int>(j), forward, first[j]});
      has_grown = true;
    }
  }
  return steps;
}

void propagate_pose(const TreeStep& step, const Joint& joint, const double* q, std::vector<WorldFrame>& frames) {
  const Displacement d = displace(joint, q + step.first_coordinate);
  const Matrix3 rotation = d.rotation * joint.rotation;  // of the second body's frame in the first body's frame
  const Vector3 origin = joint.point_first + d.translation - rotation * joint.point_second;
  WorldFrame &first = frames[static_cast<std::size_t>(joint.first)],
             &second = frames[static_cast<std::size_t>(joint.second)];
  if (step.forward) {
    second.rotation = first.rotation * rotation;
    second.origin = first.origin + first.rotation * origin;
  } else {
    first.rotation = second.rotation * rotation.transpose();
    first.origin = second.origin - first.rotation * origin;
  }
}

}  // namespace

BodyPoses body_poses(const Mechanism& mechanism, const RunResult& result) {
  if (result.coordinate_names.size() != mechanism.coordinates.size())
    throw std::invalid_argument("the run belongs to another mechanism: it has other joint coordinates");
  const Eigen::Index rows = result.time.size(), bodies = static_cast<Eigen::Index>(mechanism.bodies.size());
  BodyPoses poses{Samples(rows, 3 * bodies), Samples(rows, 4 * bodies)};
  const std::vector<TreeStep> steps = steps_from_ground(mechanism);
  std::vector<WorldFrame> frames(mechanism.bodies.size());
  for (Eigen::Index k = 0; k < rows; ++k) {
    const double* q = result.joint_position.row(k).data();
    for (const TreeStep& step : steps)
      propagate_pose(step, mechanism.joints[static_cast<std::size_t>(step.joint)], q, frames);
    for (Eigen::Index b = 0; b < bodies; ++b) {
      const WorldFrame& frame = frames[static_cast<std::size_t>(b)];
      Eigen::Vector4d quaternion = quaternion_of(frame.rotation);
      if (k > 0 && poses.orientation.row(k - 1).segment<4>(4 * b).dot(quaternion) < 0) quaternion = -quaternion;
      poses.position.row(k).segment<3>(3 * b) = frame.origin;
      poses.orientation.row(k).segment<4>(4 * b) = quaternion;
    }
  }
  return poses;
}

void add_body_poses(const Mechanism& mechanism, RunResult& result) {
  const BodyPoses poses = body_poses(mechanism, result);
  const bool planar = mechanism.space == SpaceKind::planar;
  const Eigen::Index rows = result.time.size(), moving_bodies = static_cast<Eigen::Index>(mechanism.bodies.size()) - 1;
  result.body_names.clear();
  for (std::size_t b = 1; b < mechanism.bodies.size(); ++b) result.body_names.push_back(mechanism.bodies[b].name);
  result.body_position.resize(rows, moving_bodies * result.axes);
  result.body_orientation.resize(rows, planar ? moving_bodies : 4 * moving_bodies);
  for (Eigen::Index b = 0; b < moving_bodies; ++b) {
    result.body_position.middleCols(b * result.axes, result.axes) = poses.position.middleCols(3 * (b + 1), result.axes);
    const auto quaternions = poses.orientation.middleCols(4 * (b + 1), 4);
    if (!planar) {
      result.body_orientation.middleCols(4 * b, 4) = quaternions;
      continue;
    }
    for (Eigen::Index k = 0; k < rows; ++k) {  // continuous past ±π
      const double angle = 2 * elementary::atan2(quaternions(k, 3), quaternions(k, 0));
      const double previous_angle = k == 0 ? 0 : result.body_orientation(k - 1, b);
      result.body_orientation(k, b) = previous_angle + std::remainder(angle - previous_angle, 2 * std::numbers::pi);
    }
  }
  clear_round_off(&RunResult::body_position, result);
}

}  // namespace balance
