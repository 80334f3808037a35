#include "balance/interface/specification/read_spec.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/synthesis/verification/mechanism_check.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <string>

using namespace balance;

namespace {

/// A crank about z, a thin rod, a rocker about y; the rod hangs on the crank by the joint given.
Study rssr(const std::string& joint) {
  return read_spec(R"(
space: spatial
ground: {points: {A: [0, 0, 0], D: [1, 0, 0]}}
bodies:
  crank: {mass: 1, com: [0.1, 0, 0], inertia: [0.01, 0.01, 0.01], points: {A: [0, 0, 0], B: [0.2, 0, 0]}}
  rod: {mass: 1, com: [0.5, 0, 0], inertia: [1.0e-9, 0.08, 0.08], points: {B: [0, 0, 0], C: [1.0, 0, 0]}}
  rocker: {mass: 1, com: [0.2, 0, 0], inertia: [0.01, 0.01, 0.01], points: {D: [0, 0, 0], C: [0.5, 0, 0]}}
joints:
  A: {type: revolute, connects: [ground.A, crank.A], axis: [0, 0, 1]}
  B: )" + joint + R"(
  C: {type: spherical, connects: [rod.C, rocker.C]}
  D: {type: revolute, connects: [ground.D, rocker.D], axis: [0, 1, 0]}
actuators: [A]
assembly: {D: -1.4}
motion: {duration: 1, samples: 51, from: {joints: {A: 0.3}}, to: {joints: {A: 2.5}}}
)",
                   "rssr.yaml");
}

}  // namespace

TEST_CASE("a thin rod between two spherical joints moves and costs what it does with a universal one") {
  const Study idle = rssr("{type: spherical, connects: [crank.B, rod.B]}");
  const Study held = rssr("{type: universal, connects: [crank.B, rod.B], axis: [0, 1, 0], axis2: [0, 0, 1]}");
  const CheckReport report = check_mechanism(idle);
  CHECK(report.degrees_of_freedom == 1);
  CHECK(report.gruebler_degrees_of_freedom == 2);
  REQUIRE(report.passive_freedoms.size() == 1);
  CHECK(report.passive_freedoms[0].find("rod could spin") == 0);
  CHECK(check_mechanism(held).passive_freedoms.empty());

  const RunResult a = simulate(idle.mechanism, idle.trajectories[0]),
                  b = simulate(held.mechanism, held.trajectories[0]);
  REQUIRE(a.outcome.status == MotionStatus::done);
  REQUIRE(b.outcome.status == MotionStatus::done);
  // what remains is the inertia about the rod's line, 1e-7 of the least of the others
  CHECK((a.torque - b.torque).cwiseAbs().maxCoeff() < 1e-6 * b.torque.cwiseAbs().maxCoeff());
  CHECK((a.shaking_force - b.shaking_force).cwiseAbs().maxCoeff() < 1e-6 * b.shaking_force.cwiseAbs().maxCoeff());
}

TEST_CASE("a seven-joint arm starts in the stated orientation, not half a turn off, and has eight ways to do so") {
  const Study study = read_spec(R"(
space: spatial
gravity: [0, 0, -9.81]
bodies:
  l1: {mass: 4, com: [0, 0.03, 0.12], inertia: [0.1, 0.09, 0.02], points: {P: [0, 0, 0.34]}}
  l2: {mass: 4, com: [0, 0.06, 0.04], inertia: [0.05, 0.018, 0.044]}
  l3: {mass: 3, com: [0, 0.03, 0.13], inertia: [0.08, 0.075, 0.01], points: {P: [0, 0, 0.4]}}
  l4: {mass: 2.7, com: [0, 0.067, 0.034], inertia: [0.03, 0.01, 0.029]}
  l5: {mass: 1.7, com: [0, 0.021, 0.076], inertia: [0.02, 0.018, 0.005], points: {P: [0, 0, 0.4]}}
  l6: {mass: 1.8, com: [0, 0.001, 0], inertia: [0.005, 0.0036, 0.0047]}
  l7: {mass: 0.3, com: [0, 0, 0.02], inertia: [0.001, 0.001, 0.001], points: {T: [0, 0, 0.126]}}
joints:
  J1: {type: revolute, connects: [ground.origin, l1.origin]}
  J2: {type: revolute, connects: [l1.P, l2.origin], axis: [0, 1, 0]}
  J3: {type: revolute, connects: [l2.origin, l3.origin]}
  J4: {type: revolute, connects: [l3.P, l4.origin], axis: [0, -1, 0]}
  J5: {type: revolute, connects: [l4.origin, l5.origin]}
  J6: {type: revolute, connects: [l5.P, l6.origin], axis: [0, 1, 0]}
  J7: {type: revolute, connects: [l6.origin, l7.origin]}
actuators: [J1, J2, J3, J4, J5, J6, J7]
tool: l7.T
assembly: {J2: 0.5, J4: 1.2, J6: 0.6}
motion:
  duration: 2
  samples: 101
  from: {tool: [0.4, 0.1, 0.6], rpy: [0, 3.0, 0], joints: {J3: 0.1}}
  to: {tool: [0.5, -0.2, 0.5], rpy: [0.1, 2.8, 0.3], joints: {J3: -0.1}}
trajectories: {t: {law: 3-4-5, drive: tool, remaining: [J3]}}
)",
                                "arm.yaml");
  CHECK(check_mechanism(study).modes.size() == 8);
  const RunResult result = simulate(study.mechanism, study.trajectories[0]);
  REQUIRE(result.outcome.status == MotionStatus::done);
  // the quaternion of a turn by 3 rad about y
  CHECK(result.tool_orientation(0, 0) == doctest::Approx(std::cos(1.5)).epsilon(1e-12));
  CHECK(result.tool_orientation(0, 2) == doctest::Approx(std::sin(1.5)).epsilon(1e-12));
  CHECK(result.joint_position(100, 2) == doctest::Approx(-0.1).epsilon(1e-12));
}
