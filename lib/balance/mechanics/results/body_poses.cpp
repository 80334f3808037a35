#include "balance/mechanics/results/body_poses.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/rotation.hpp"
#include "balance/mechanics/results/round_off.hpp"

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace balance::results {
namespace {

/// One of the successive displacements of a joint, in the axes that those before it have turned.
struct JointStep {
  enum class Kind { rotation, slide, offset };
  Kind kind;
  Vector3 axis;        ///< of an offset: the displacement itself
  int coordinate = 0;  ///< of the joint; an offset has none
};

/// From the joint's point on the first body to that on the second, in the first body's axes.
std::vector<JointStep> list_joint_displacements(const Joint& joint) {
  const auto rotation = [](const Vector3& axis, int k) { return JointStep{JointStep::Kind::rotation, axis, k}; };
  const auto slide = [](const Vector3& axis, int k) { return JointStep{JointStep::Kind::slide, axis, k}; };
  const Vector3 x = Vector3::UnitX(), y = Vector3::UnitY(), z = Vector3::UnitZ();
  const Vector3 &u = joint.axis, &v = joint.axis2;
  switch (joint.type) {
    case JointType::fixed: return {};
    case JointType::revolute: return {rotation(u, 0)};
    case JointType::prismatic: return {slide(u, 0)};
    case JointType::pin_slot: return {slide(u, 0), rotation(z, 1)};
    case JointType::cylindrical: return {slide(u, 1), rotation(u, 0)};
    case JointType::universal: return {rotation(u, 0), rotation(v, 1)};
    case JointType::spherical: return {rotation(x, 0), rotation(y, 1), rotation(z, 2)};
    case JointType::planar: return {slide(v, 0), slide(u.cross(v), 1), rotation(u, 2)};
    case JointType::free:
      return {slide(x, 0), slide(y, 1), slide(z, 2), rotation(x, 3), rotation(y, 4), rotation(z, 5)};
    case JointType::rolling_disc:
      return {slide(v, 0),
              slide(u.cross(v), 1),
              rotation(u, 2),
              rotation(v, 3),
              {JointStep::Kind::offset, joint.radius * u},
              rotation(u.cross(v), 4)};
    case JointType::rolling_sphere:
      return {slide(v, 0),    slide(u.cross(v), 1), {JointStep::Kind::offset, joint.radius * u},
              rotation(x, 2), rotation(y, 3),       rotation(z, 4)};
  }
  return {};
}

/// The motion of a frame given in a moving body's axes, as seen in the world.
BodyMotion compose(const BodyMotion& body, const BodyMotion& frame) {
  const Vector3 &w = body.angular_velocity, &alpha = body.angular_acceleration;
  const Vector3 d = body.rotation * frame.position, slip = body.rotation * frame.velocity,
                turn = body.rotation * frame.angular_velocity;
  BodyMotion motion;
  motion.rotation = body.rotation * frame.rotation;
  motion.position = body.position + d;
  motion.velocity = body.velocity + slip + w.cross(d);
  motion.acceleration =
      body.acceleration + body.rotation * frame.acceleration + 2 * w.cross(slip) + alpha.cross(d) + w.cross(w.cross(d));
  motion.angular_velocity = w + turn;
  motion.angular_acceleration = alpha + body.rotation * frame.angular_acceleration + w.cross(turn);
  return motion;
}

/// The motion by one displacement, in the axes in which it is given.
BodyMotion step_motion(const JointStep& step, const double* q, const double* dq, const double* ddq) {
  BodyMotion motion;
  const int k = step.coordinate;
  switch (step.kind) {
    case JointStep::Kind::rotation:
      motion.rotation = rotation_about(step.axis, q[k]);
      motion.angular_velocity = dq[k] * step.axis;
      motion.angular_acceleration = ddq[k] * step.axis;
      break;
    case JointStep::Kind::slide:
      motion.position = q[k] * step.axis;
      motion.velocity = dq[k] * step.axis;
      motion.acceleration = ddq[k] * step.axis;
      break;
    case JointStep::Kind::offset: motion.position = step.axis; break;
  }
  return motion;
}

/// The motion of a body as seen from a frame, from that of the frame as seen from the body.
BodyMotion invert(const BodyMotion& frame) {
  const Matrix3 back = frame.rotation.transpose();
  const Vector3 &w = frame.angular_velocity, &alpha = frame.angular_acceleration;
  // R_t r = −p, differentiated twice in the body's axes
  BodyMotion motion;
  motion.rotation = back;
  motion.position = -(back * frame.position);
  motion.velocity = -(back * (frame.velocity - w.cross(frame.position)));
  motion.acceleration = -(back * (frame.acceleration - alpha.cross(frame.position) - 2 * w.cross(frame.velocity) +
                                  w.cross(w.cross(frame.position))));
  motion.angular_velocity = -(back * w);
  motion.angular_acceleration = -(back * alpha);
  return motion;
}

/// A joint on the path from the ground to a body.
struct TreeStep {
  JointId joint = 0;
  bool forward = true;  ///< towards the joint's second body
  Eigen::Index first_coordinate = 0;
  std::vector<JointStep> displacements;
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
  is_reached[model::ground] = true;
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
      steps.push_back({static_cast<int>(j), forward, first[j], list_joint_displacements(mechanism.joints[j])});
      has_grown = true;
    }
  }
  return steps;
}

/// Motion of the second body's frame as seen from the first body.
BodyMotion motion_between_bodies(const TreeStep& step, const Joint& joint, const double* q, const double* dq,
                                 const double* ddq) {
  BodyMotion motion;
  for (const JointStep& displacement : step.displacements)
    motion = compose(motion, step_motion(displacement, q, dq, ddq));
  motion.rotation = motion.rotation * joint.rotation;
  motion.position = joint.point_first + motion.position;
  BodyMotion origin;  // in the second body's axes, from its point
  origin.position = -joint.point_second;
  return compose(motion, origin);
}

void propagate_motion(const TreeStep& step, const Joint& joint, const double* q, const double* dq, const double* ddq,
                      std::vector<BodyMotion>& bodies) {
  const Eigen::Index k = step.first_coordinate;
  const BodyMotion relative = motion_between_bodies(step, joint, q + k, dq + k, ddq + k);
  BodyMotion &first = bodies[static_cast<std::size_t>(joint.first)],
             &second = bodies[static_cast<std::size_t>(joint.second)];
  if (step.forward)
    second = compose(first, relative);
  else
    first = compose(second, invert(relative));
}

void require_same_mechanism(const Mechanism& mechanism, const RunResult& result) {
  if (result.coordinate_names.size() != mechanism.coordinates.size())
    throw std::invalid_argument("the run belongs to another mechanism: it has other joint coordinates");
}

}  // namespace

BodyPoses body_poses(const Mechanism& mechanism, const RunResult& result) {
  require_same_mechanism(mechanism, result);
  const Eigen::Index rows = result.time.size(), bodies = static_cast<Eigen::Index>(mechanism.bodies.size());
  BodyPoses poses{Samples(rows, 3 * bodies), Samples(rows, 4 * bodies)};
  const std::vector<TreeStep> steps = steps_from_ground(mechanism);
  std::vector<BodyMotion> bodies_at_sample(mechanism.bodies.size());
  const std::vector<double> at_rest(mechanism.coordinates.size(), 0);
  for (Eigen::Index k = 0; k < rows; ++k) {
    const double* q = result.joint_position.row(k).data();
    for (const TreeStep& step : steps)
      propagate_motion(step, mechanism.joints[static_cast<std::size_t>(step.joint)], q, at_rest.data(), at_rest.data(),
                       bodies_at_sample);
    for (Eigen::Index b = 0; b < bodies; ++b) {
      const BodyMotion& frame = bodies_at_sample[static_cast<std::size_t>(b)];
      Eigen::Vector4d quaternion = quaternion_of(frame.rotation);
      if (k > 0 && poses.orientation.row(k - 1).segment<4>(4 * b).dot(quaternion) < 0) quaternion = -quaternion;
      poses.position.row(k).segment<3>(3 * b) = frame.position;
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

std::vector<BodyMotion> body_motions_at(const Mechanism& mechanism, const VectorX& position, const VectorX& velocity,
                                        const VectorX& acceleration) {
  std::vector<BodyMotion> motions(mechanism.bodies.size());
  for (const TreeStep& step : steps_from_ground(mechanism))
    propagate_motion(step, mechanism.joints[static_cast<std::size_t>(step.joint)], position.data(), velocity.data(),
                     acceleration.data(), motions);
  return motions;
}

std::vector<std::vector<BodyMotion>> body_motions(const Mechanism& mechanism, const RunResult& result,
                                                  Eigen::Index rows) {
  require_same_mechanism(mechanism, result);
  const std::vector<TreeStep> steps = steps_from_ground(mechanism);
  std::vector<std::vector<BodyMotion>> motions(static_cast<std::size_t>(rows),
                                               std::vector<BodyMotion>(mechanism.bodies.size()));
  for (Eigen::Index k = 0; k < rows; ++k)
    for (const TreeStep& step : steps)
      propagate_motion(step, mechanism.joints[static_cast<std::size_t>(step.joint)],
                       result.joint_position.row(k).data(), result.joint_velocity.row(k).data(),
                       result.joint_acceleration.row(k).data(), motions[static_cast<std::size_t>(k)]);
  return motions;
}

}  // namespace balance::results
