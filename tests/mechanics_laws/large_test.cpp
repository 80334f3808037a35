// Hundreds of bodies and loops: right, and at a cost that grows as the mechanism does.

#include "mechanics_check.hpp"

#include "finite_difference_state.hpp"

#include "balance/foundation/base/rotation.hpp"
#include "balance/synthesis/conditions/conditions.hpp"
#include "balance/synthesis/verification/mechanism_check.hpp"

#include <doctest/doctest.h>

#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <numeric>

using namespace laws;
using namespace balance;

namespace {

Body rod(int index, double length, bool planar) {
  Body body;
  body.name = "body" + std::to_string(index);
  body.mass = 1 + 0.1 * (index % 7);
  body.com = {0.4 * length, 0.1 * length, planar ? 0 : 0.05 * length};
  body.inertia = planar ? Matrix3(Vector3(0, 0, 0.1).asDiagonal()) : Matrix3(Vector3(0.02, 0.1, 0.1).asDiagonal());
  body.inertia *= length * length;
  body.points = {{"A", Vector3::Zero()}, {"B", {length, 0, 0}}};
  return body;
}

Mechanism empty(SpaceKind space) {
  Mechanism m;
  m.space = space;
  m.gravity = space == SpaceKind::planar ? Vector3(0, -9.81, 0) : Vector3(0, 0, -9.81);
  m.bodies.emplace_back();
  m.bodies[0].name = "ground";
  return m;
}

Joint pin(int first, int second, const Vector3& P, const Vector3& Q) {
  Joint joint;
  joint.name = "J" + std::to_string(first) + "_" + std::to_string(second);
  joint.first = first, joint.second = second, joint.point_first = P, joint.point_second = Q;
  return joint;
}

/// Every joint with a motor; each moves a little, so that the end does not whip.
Experiment chain(int bodies, SpaceKind space) {
  using enum JointType;
  static const JointType mixed[] = {revolute,    universal, prismatic,        spherical,
                                    cylindrical, revolute,  JointType::planar};
  const bool flat = space == SpaceKind::planar;
  Experiment out{empty(space), {}};
  Mechanism& m = out.mechanism;
  for (int b = 1; b <= bodies; ++b) {
    m.bodies.push_back(rod(b, 0.2, flat));
    Joint joint = pin(b - 1, b, b == 1 ? Vector3::Zero() : Vector3(0.2, 0, 0), Vector3::Zero());
    if (flat) {
      joint.type = b % 5 == 0 ? prismatic : b % 11 == 0 ? pin_slot : revolute;
      if (joint.type != revolute) joint.axis = Vector3(0.6, 0.8, 0);
    } else {
      joint.type = mixed[b % 7];
      joint.axis = Vector3(0.36, 0.48, 0.8), joint.axis2 = Vector3(0.8, -0.6, 0);
    }
    m.joints.push_back(joint);
  }
  m.coordinates = list_coordinates(space, m.joints);
  Trajectory& t = out.trajectory;
  t.drive = DriveKind::joints;
  t.samples = 21;
  for (int c = 0; c < static_cast<int>(m.coordinates.size()); ++c) {
    m.actuators.push_back(c);
    t.from.joints.push_back({c, 0.05 * std::sin(c)});
    t.to.joints.push_back({c, 0.05 * std::sin(c) + 0.5 * std::cos(3 * c) / bodies});
  }
  m.tool = Tool{bodies, "B", {0.2, 0, 0}};
  return out;
}

/// Four-bars in a row, the rocker of each the crank of the next, one motor for all.
Experiment ladder(int loops) {
  Experiment out{empty(SpaceKind::planar), {}};
  Mechanism& m = out.mechanism;
  const double tilt = 1.2, crank = 0.2, base = 0.3;
  m.bodies.push_back(rod(1, crank, true));
  m.joints.push_back(pin(0, 1, Vector3::Zero(), Vector3::Zero()));
  m.assembly.push_back({0, tilt});
  for (int k = 1; k <= loops; ++k) {
    const int before = k == 1 ? 1 : 2 * k - 1, coupler = 2 * k, rocker = 2 * k + 1;
    m.bodies.push_back(rod(coupler, base, true));
    m.bodies.push_back(rod(rocker, crank, true));
    m.joints.push_back(pin(0, rocker, {k * base, 0, 0}, Vector3::Zero()));
    m.joints.push_back(pin(before, coupler, {crank, 0, 0}, Vector3::Zero()));
    m.joints.push_back(pin(coupler, rocker, {base, 0, 0}, {crank, 0, 0}));
    m.assembly.push_back({3 * k - 2, tilt});
    m.assembly.push_back({3 * k - 1, -tilt});
  }
  m.coordinates = list_coordinates(m.space, m.joints);
  m.actuators = {0};
  Trajectory& t = out.trajectory;
  t.drive = DriveKind::joints;
  t.samples = 21;
  t.from.joints = {{0, tilt}};
  t.to.joints = {{0, tilt + 0.6}};
  return out;
}

void lawful(const char* name, const Experiment& experiment) {
  const std::clock_t start = std::clock();
  const Run one = run(name, experiment.mechanism, experiment.trajectory);
  if (one.result.outcome.status != MotionStatus::done) return;
  if (std::getenv("BALANCE_TIMES") != nullptr)
    std::printf("%s: %.3f s\n", name, static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  Findings findings;
  judge_instants(one, 3, findings);
  CHECK_MESSAGE(findings.none(), name << ": " << findings.text());
}

}  // namespace

TEST_CASE("chains of two hundred bodies, in the plane and with mixed joints in space") {
  lawful("planar chain", chain(200, SpaceKind::planar));
  lawful("spatial chain", chain(200, SpaceKind::spatial));
}

TEST_CASE("a hundred four-bars in a row, driven by one motor") {
  const Experiment experiment = ladder(100);
  lawful("ladder", experiment);
  // all are parallelograms: every rocker turns as the crank does
  const Run one = run("ladder", experiment.mechanism, experiment.trajectory);
  for (int k = 1; k <= 100; ++k)
    CHECK((one.result.joint_position.col(3 * k - 2) - one.result.joint_position.col(0)).cwiseAbs().maxCoeff() < 1e-9);
}

TEST_CASE("a chain of twenty bars has the force conditions that follow from its last bar inwards") {
  // each body's first moment in its own frame, with all that hangs on its end lumped there, must vanish: two per turning bar
  Experiment experiment = chain(20, SpaceKind::planar);
  for (Joint& joint : experiment.mechanism.joints) joint.type = JointType::revolute, joint.axis = Vector3::UnitZ();
  experiment.mechanism.coordinates = list_coordinates(SpaceKind::planar, experiment.mechanism.joints);
  experiment.mechanism.actuators.resize(20);
  std::iota(experiment.mechanism.actuators.begin(), experiment.mechanism.actuators.end(), 0);
  const Conditions conditions = derive_conditions(experiment.mechanism, {{GoalKind::force, false}});
  REQUIRE(conditions.status == ConditionsStatus::done);
  CHECK(conditions.rank == 40);
  // body b's row for mx: mx_b + 0.2 (m_{b+1} + … + m_20) = 0
  for (int r = 0; r < conditions.rank; ++r) {
    const dynamics::Parameter& pivot = conditions.parameters[conditions.pivots[r]];
    for (int p = 0; p < conditions.matrix.cols(); ++p) {
      const dynamics::Parameter& other = conditions.parameters[p];
      double want = p == conditions.pivots[r] ? 1 : 0;
      if (pivot.symbol == "mx" && other.symbol == "m" && other.index > pivot.index) want = 0.2;
      CHECK(std::abs(conditions.matrix(r, p) - want) < 1e-10);
    }
  }
}
