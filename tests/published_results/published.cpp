#include "published.hpp"

#include "balance/interface/specification/read_spec.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <doctest/doctest.h>

namespace published {

balance::Study load(const std::string& file) {
  return balance::read_spec_file(std::string(BALANCE_CONFIGS "/") + file);
}

Trajectory make_trajectory(const balance::Study& study, const std::string& name, long samples) {
  for (Trajectory one : study.trajectories) {
    if (one.name != name) continue;
    if (samples > 0) one.samples = samples;
    return one;
  }
  FAIL("no trajectory " << name);
  return {};
}

RunResult run(const Mechanism& mechanism, const Trajectory& trajectory) {
  RunResult result = balance::simulate(mechanism, trajectory);
  REQUIRE_MESSAGE(result.outcome.status == MotionStatus::done, mechanism.name << ": " << result.outcome.reason);
  return result;
}

RunResult run(const std::string& file, const std::string& name, long samples) {
  const balance::Study study = load(file);
  return run(study.mechanism, make_trajectory(study, name, samples));
}

long coordinate(const Mechanism& mechanism, const std::string& name) {
  for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c)
    if (mechanism.coordinates[c].name == name) return static_cast<long>(c);
  FAIL("no coordinate " << name);
  return -1;
}

const balance::Metric& metric(const RunResult& result, const std::string& quantity) {
  for (const balance::Metric& one : result.metrics)
    if (one.quantity == quantity) return one;
  FAIL("no metric " << quantity);
  return result.metrics.front();
}

Matrix3 about_z(double J) { return Vector3(0, 0, J).asDiagonal(); }

Mechanism empty(balance::SpaceKind space, const Vector3& gravity) {
  Mechanism m;
  m.space = space;
  m.gravity = gravity;
  m.bodies.emplace_back();
  m.bodies[0].name = "ground";
  return m;
}

int add_body(Mechanism& m, double mass, const Vector3& com, const Matrix3& inertia) {
  balance::Body body;
  body.name = "body" + std::to_string(m.bodies.size());
  body.mass = mass, body.com = com, body.inertia = inertia;
  m.bodies.push_back(body);
  return static_cast<int>(m.bodies.size()) - 1;
}

int add_body(Mechanism& m, double mass, const Vector3& com, double J) { return add_body(m, mass, com, about_z(J)); }

int add_joint(Mechanism& m, balance::JointType type, int first, const Vector3& P, int second, const Vector3& Q,
              const Vector3& axis) {
  balance::Joint joint;
  joint.name = "J" + std::to_string(m.joints.size() + 1);
  joint.type = type, joint.first = first, joint.second = second;
  joint.point_first = P, joint.point_second = Q, joint.axis = axis;
  m.joints.push_back(joint);
  const int c = static_cast<int>(m.coordinates.size());
  m.coordinates = balance::list_coordinates(m.space, m.joints);
  return c;
}

void add_disc(Mechanism& m, int body, const Vector3& at, const Vector3& axis, int follows, double ratio, double mass,
              const Matrix3& inertia) {
  balance::Disc disc;
  disc.name = "d" + std::to_string(m.discs.size() + 1);
  disc.body = body, disc.position = at, disc.axis = axis;
  disc.follows = follows, disc.ratio = ratio, disc.mass = mass, disc.inertia = inertia;
  m.discs.push_back(disc);
}

Trajectory joint_motion(const std::vector<balance::CoordinateId>& coordinates, const VectorX& from, const VectorX& to,
                        double duration, long samples) {
  Trajectory t;
  t.name = "test";
  t.drive = balance::DriveKind::joints;
  t.duration = duration;
  t.samples = samples;
  for (std::size_t k = 0; k < coordinates.size(); ++k) {
    t.from.joints.push_back({coordinates[k], from[static_cast<long>(k)]});
    t.to.joints.push_back({coordinates[k], to[static_cast<long>(k)]});
  }
  return t;
}

double draw(std::mt19937& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

}  // namespace published
