#pragma once
/// Every mechanism of configs/ on every one of its trajectories and a crowd of random ones, and what the laws of mechanics say of it, worked out from
/// the joint coordinates over time alone: poses by walking from joint to joint, velocities and accelerations by differences,
/// masses as clouds of points. Nothing here uses the engine's trees or recursions.

#include "balance/mechanics/results/result.hpp"
#include "balance/motion/study/study.hpp"

#include <functional>
#include <string>
#include <vector>

namespace laws {

using balance::Matrix3;
using balance::Mechanism;
using balance::RunResult;
using balance::Samples;
using balance::Vector3;
using balance::VectorX;

struct Pose {
  Matrix3 R = Matrix3::Identity();
  Vector3 p = Vector3::Zero();
};

/// A joint's own displacement as mechanics/model/mechanism.hpp defines it: pose of the second body's frame, its origin put at the
/// joint's point, in the first body's axes from the joint's point on the first body.
Pose displacement(const balance::Joint& joint, bool planar, const double* q);

/// World pose of every body when the coordinates have the values q, by the joints in the order in which they connect.
std::vector<Pose> poses(const Mechanism& mechanism, const VectorX& q);

struct Run {
  std::string name;  ///< "file: trajectory"
  Mechanism mechanism;
  balance::Trajectory trajectory;
  RunResult result;
  std::vector<std::vector<Pose>> poses;  ///< per sample and body
  std::vector<bool> smooth;              ///< the samples up to three away lie on the same smooth piece

  long samples() const { return result.time.size(); }
  double step() const { return result.time[1] - result.time[0]; }
  double length() const { return balance::model::characteristic_length(mechanism); }
  Vector3 row(const Samples& array, long k,
              long vector = 0) const;  ///< vector number `vector` of a row (axes columns each)
  Vector3 moment(const Samples& array, long k, long vector = 0) const;  ///< planar: along z
};

/// Sanitizers make every step many times as long: a part of the mechanisms must do.
#ifdef BALANCE_SANITIZED
inline constexpr unsigned fewer = 4;
#else
inline constexpr unsigned fewer = 1;
#endif

/// Of all configs with bodies, or under sanitizers of some.
std::vector<std::string> config_names();
balance::Study load(const std::string& file);
/// RunResult::outcome may say why there are no samples.
Run attempt(const std::string& name, const Mechanism& mechanism, const balance::Trajectory& trajectory);
/// The same, and a run that does not end well is a failed check.
Run run(const std::string& name, const Mechanism& mechanism, const balance::Trajectory& trajectory);

/// Calls back with every config's every trajectory and with the random mechanisms, on `samples` samples. A run that does not end well is a failed check.
void for_each_run(long samples, const std::function<void(const Run&)>& test);

/// First and second derivative at sample k of a column, from seven samples around it: the error is of the order h^6.
double rate(const Samples& array, long k, long column, double h);
double second_rate(const Samples& array, long k, long column, double h);

/// Points that have together the mass, the centre of mass and the inertia of what moves with a body: itself, attachments,
/// discs.
struct Cloud {
  std::vector<double> mass;
  std::vector<int> body;  ///< that carries the point
  Samples position;       ///< samples × 3 points

  Vector3 place(long k, long point) const { return position.row(k).segment<3>(3 * point).transpose(); }
  Vector3 velocity(long k, long point, double h) const;
  Vector3 acceleration(long k, long point, double h) const;
};
Cloud cloud(const Run& run);

/// A force and its moment about the world's origin.
struct Total {
  Vector3 force = Vector3::Zero(), moment = Vector3::Zero();
  void add(const Vector3& f, const Vector3& at, const Vector3& m = Vector3::Zero()) {
    force += f;
    moment += at.cross(f) + m;
  }
};

/// Rate of momentum of each body with what it carries.
std::vector<Total> momentum_rates(const Run& run, const Cloud& cloud, long k);
/// Weight of each body with what it carries.
std::vector<Total> weights(const Run& run, const Cloud& cloud, long k);
/// What loads do to each body.
std::vector<Total> loads(const Run& run, long k);
/// What springs between points do to each body.
std::vector<Total> springs(const Run& run, long k);
/// What keeps constraints on speeds, from the ground on each body, by the result's forces.
std::vector<Total> keepers(const Run& run, long k);
/// What joints do to each body, by the result's reactions.
std::vector<Total> reactions(const Run& run, long k);

/// Largest Σ |m a| over the samples [N]: what the equality of forces is measured by.
double force_scale(const Run& run, const Cloud& cloud);

/// The worst of many relative errors, with its sample. Not a number counts as infinitely bad.
struct Worst {
  double error = 0;
  long sample = -1;
  void see(double value, long k) {
    if (value <= error) return;
    error = value == value ? value : 1e300;
    sample = k;
  }
};

}  // namespace laws
