#include "runs.hpp"

#include "random_mechanisms.hpp"

#include "balance/foundation/base/rotation.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/mechanics/trajectory/motion_law.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

namespace laws {

using balance::JointType;
using balance::rotation_about;

Pose displacement(const balance::Joint& joint, bool planar, const double* q) {
  const Vector3 &u = joint.axis, &v = joint.axis2, x = Vector3::UnitX(), y = Vector3::UnitY(), z = Vector3::UnitZ();
  Pose out;
  switch (joint.type) {
    case JointType::revolute: out.R = rotation_about(planar ? z : u, q[0]); break;
    case JointType::prismatic: out.p = q[0] * u; break;
    case JointType::fixed: break;
    case JointType::pin_slot: out = {rotation_about(z, q[1]), q[0] * u}; break;
    case JointType::cylindrical: out = {rotation_about(u, q[0]), q[1] * u}; break;
    case JointType::universal: out.R = rotation_about(u, q[0]) * rotation_about(v, q[1]); break;
    case JointType::spherical:
      out.R = rotation_about(x, q[0]) * rotation_about(y, q[1]) * rotation_about(z, q[2]);
      break;
    case JointType::planar: out = {rotation_about(u, q[2]), q[0] * v + q[1] * u.cross(v)}; break;
    case JointType::free:
      out = {rotation_about(x, q[3]) * rotation_about(y, q[4]) * rotation_about(z, q[5]), {q[0], q[1], q[2]}};
      break;
    case JointType::rolling_disc: {
      const Matrix3 leaning = rotation_about(u, q[2]) * rotation_about(v, q[3]);
      out = {leaning * rotation_about(u.cross(v), q[4]), q[0] * v + q[1] * u.cross(v) + joint.radius * leaning * u};
      break;
    }
    case JointType::rolling_sphere:
      out.R = rotation_about(x, q[2]) * rotation_about(y, q[3]) * rotation_about(z, q[4]);
      out.p = q[0] * v + q[1] * u.cross(v) + joint.radius * u;
      break;
  }
  out.R = out.R * joint.rotation;
  return out;
}

std::vector<Pose> poses(const Mechanism& mechanism, const VectorX& q) {
  const bool planar = mechanism.space == balance::SpaceKind::planar;
  std::vector<Pose> world(mechanism.bodies.size());
  std::vector<bool> known(mechanism.bodies.size(), false);
  known[balance::model::ground] = true;
  for (bool more = true; more;) {
    more = false;
    std::size_t c = 0;
    for (const balance::Joint& joint : mechanism.joints) {
      const double* values = q.data() + c;
      c += static_cast<std::size_t>(balance::model::joint_degrees_of_freedom(joint.type));
      if (known[joint.first] == known[joint.second]) continue;
      const Pose d = displacement(joint, planar, values);
      if (known[joint.first]) {
        const Pose& a = world[joint.first];
        const Matrix3 R = a.R * d.R;
        world[joint.second] = {R, a.p + a.R * (joint.point_first + d.p) - R * joint.point_second};
      } else {
        const Pose& b = world[joint.second];
        const Matrix3 R = b.R * d.R.transpose();
        world[joint.first] = {R, b.p + b.R * joint.point_second - R * (joint.point_first + d.p)};
      }
      known[joint.first] = known[joint.second] = more = true;
    }
  }
  return world;
}

namespace {

Vector3 padded(const Samples& array, long k, long vector, int axes) {
  Vector3 out = Vector3::Zero();
  for (int i = 0; i < axes; ++i) out[i] = array(k, vector * axes + i);
  return out;
}

}  // namespace

Vector3 Run::row(const Samples& array, long k, long vector) const { return padded(array, k, vector, result.axes); }

Vector3 Run::moment(const Samples& array, long k, long vector) const {
  return result.moment_axes == 1 ? Vector3(0, 0, array(k, vector)) : padded(array, k, vector, 3);
}

std::vector<std::string> config_names() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(BALANCE_CONFIGS)) {
    if (entry.path().extension() != ".yaml") continue;
    std::ifstream file(entry.path());
    for (std::string line; std::getline(file, line);)  // suites are specs of another kind
      if (line.rfind("bodies:", 0) == 0) names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  REQUIRE(names.size() >= 25);
  std::vector<std::string> some;
  for (std::size_t i = 0; i < names.size(); i += fewer) some.push_back(names[i]);
  return some;
}

balance::Study load(const std::string& file) {
  return balance::read_spec_file(std::string(BALANCE_CONFIGS "/") + file);
}

Run attempt(const std::string& name, const Mechanism& mechanism, const balance::Trajectory& trajectory) {
  Run out{name, mechanism, trajectory, balance::simulate(mechanism, trajectory), {}, {}};
  if (out.result.outcome.status != balance::MotionStatus::done) return out;
  const long N = out.samples();
  const double h = out.step(), T = out.result.time[N - 1];
  for (long k = 0; k < N; ++k) {
    out.poses.push_back(poses(mechanism, out.result.joint_position.row(k).transpose()));
    bool smooth = k >= 3 && k < N - 3;
    for (const double tau : balance::trajectory::find_acceleration_jumps(trajectory.law))
      smooth = smooth && std::abs(tau * T - out.result.time[k]) > 2.999999 * h;
    out.smooth.push_back(smooth);
  }
  return out;
}

Run run(const std::string& name, const Mechanism& mechanism, const balance::Trajectory& trajectory) {
  Run out = attempt(name, mechanism, trajectory);
  CHECK_MESSAGE(out.result.outcome.status == balance::MotionStatus::done, name << ": " << out.result.outcome.reason);
  return out;
}

namespace {

void for_each_random_run(long samples, const std::function<void(const Run&)>& test) {
  constexpr std::uint32_t seeds = 40 / fewer;
  for (const balance::SpaceKind space : {balance::SpaceKind::planar, balance::SpaceKind::spatial}) {
    std::uint32_t made = 0;
    for (std::uint32_t seed = 1; seed <= seeds; ++seed) {
      std::optional<Experiment> experiment = random_experiment(space, seed);
      if (!experiment) continue;
      ++made;
      experiment->trajectory.samples = samples;
      const std::string kind = space == balance::SpaceKind::planar ? "planar " : "spatial ";
      const Run one = run(kind + experiment->mechanism.name, experiment->mechanism, experiment->trajectory);
      INFO(one.name);
      if (one.result.outcome.status == balance::MotionStatus::done) test(one);
    }
    CHECK(made > seeds / 2);  // most of them can be driven
  }
}

}  // namespace

void for_each_run(long samples, const std::function<void(const Run&)>& test) {
  for_each_random_run(samples, test);
  const std::vector<std::string> names = config_names();
  for (const std::string& file : names) {
    const balance::Study study = load(file);
    CHECK_MESSAGE(!study.trajectories.empty(), file);
    for (balance::Trajectory trajectory : study.trajectories) {
      if (trajectory.name == "workspace") continue;  // rests at its poses; what leads from one to the next is no motion
      trajectory.samples = samples;
      const Run one = run(file + ": " + trajectory.name, study.mechanism, trajectory);
      INFO(one.name);
      if (one.result.outcome.status == balance::MotionStatus::done) test(one);
    }
  }
}

double rate(const Samples& array, long k, long c, double h) {
  return (45 * (array(k + 1, c) - array(k - 1, c)) - 9 * (array(k + 2, c) - array(k - 2, c)) +
          (array(k + 3, c) - array(k - 3, c))) /
         (60 * h);
}

double second_rate(const Samples& array, long k, long c, double h) {
  const double here = array(k, c);
  return (270 * ((array(k + 1, c) - here) + (array(k - 1, c) - here)) -
          27 * ((array(k + 2, c) - here) + (array(k - 2, c) - here)) +
          2 * ((array(k + 3, c) - here) + (array(k - 3, c) - here))) /
         (180 * h * h);
}

}  // namespace laws
