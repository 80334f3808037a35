#pragma once
/// Poses and motions of all bodies during a run, computed from its joint coordinates.

#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/results/result.hpp"

#include <vector>

namespace balance::results {

/// Row k of both belongs to result.time[k]; B bodies including the ground. World axes.
struct BodyPoses {
  Samples position;     ///< N×3B: the bodies' origins [m]; z = 0 in planar mechanisms
  Samples orientation;  ///< N×4B: unit quaternions w x y z, with the sign that makes them continuous
};

/// @param result a completed run of this mechanism
/// @throws std::invalid_argument if the numbers of joint coordinates of run and mechanism differ
BodyPoses body_poses(const Mechanism& mechanism, const RunResult& result);

/// Fills the result's body_names, body_position and body_orientation.
/// @throws std::invalid_argument as body_poses
void add_body_poses(const Mechanism& mechanism, RunResult& result);

/// Motion of a body, or of a frame fixed to one. World axes.
struct BodyMotion {
  Matrix3 rotation = Matrix3::Identity();
  Vector3 position = Vector3::Zero(), velocity = Vector3::Zero(), acceleration = Vector3::Zero();  ///< of the origin
  Vector3 angular_velocity = Vector3::Zero(), angular_acceleration = Vector3::Zero();

  // of a point fixed to the body, r in the body's axes
  Vector3 point_position(const Vector3& r) const { return position + rotation * r; }
  Vector3 point_velocity(const Vector3& r) const { return velocity + angular_velocity.cross(rotation * r); }
  Vector3 point_acceleration(const Vector3& r) const {
    const Vector3 d = rotation * r;
    return acceleration + angular_acceleration.cross(d) + angular_velocity.cross(angular_velocity.cross(d));
  }
};

/// The motions of all bodies, the ground included, at the first rows of a run: motions[row][body]. They follow from the
/// run's joint coordinates, rates and accelerations without differences.
/// @throws std::invalid_argument as body_poses
std::vector<std::vector<BodyMotion>> body_motions(const Mechanism& mechanism, const RunResult& result,
                                                  Eigen::Index rows);

/// The motions of all bodies for given joint coordinates, rates and accelerations, which close the loops.
/// @param position, velocity, acceleration per coordinate of the mechanism
std::vector<BodyMotion> body_motions_at(const Mechanism& mechanism, const VectorX& position, const VectorX& velocity,
                                        const VectorX& acceleration);

}  // namespace balance::results
