#include "balance/motion/simulation/simulate.hpp"
#include "balance/interface/specification/read_spec.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <string>

using namespace balance;

namespace {

/// Two links of 0.5 m and 0.4 m in the plane.
std::string arm(const std::string& rest) {
  return R"(
space: planar
gravity: [0, -9.81]
bodies:
  upper: {mass: 2, com: [0.25, 0], inertia: 0.04, points: {A: [0, 0], B: [0.5, 0]}}
  lower: {mass: 1, com: [0.2, 0], inertia: 0.013, points: {B: [0, 0], T: [0.4, 0]}}
joints:
  J1: {type: revolute, connects: [ground.origin, upper.A]}
  J2: {type: revolute, connects: [upper.B, lower.B]}
actuators: [J1, J2]
tool: lower.T
)" + rest;
}

RunResult run(const std::string& text, std::size_t trajectory = 0) {
  const Study study = read_spec(text, "arm.yaml");
  return simulate(study.mechanism, study.trajectories.at(trajectory));
}

}  // namespace

TEST_CASE("joints driven between two tool poses move the tool from the one to the other") {
  const RunResult result = run(arm(R"(
assembly: {J2: 1}
motion: {duration: 1, samples: 51, from: {tool: [0.6, 0.2]}, to: {tool: [0.3, 0.5]}}
trajectories: {swing: {law: cycloidal, drive: joints}}
)"));
  REQUIRE(result.outcome.status == MotionStatus::done);
  CHECK(result.tool_position(0, 0) == doctest::Approx(0.6).epsilon(1e-12));
  CHECK(result.tool_position(50, 1) == doctest::Approx(0.5).epsilon(1e-12));
  // halfway every joint has made half its way, which the tool has not
  const double half = (result.joint_position(0, 0) + result.joint_position(50, 0)) / 2;
  CHECK(result.joint_position(25, 0) == doctest::Approx(half).epsilon(1e-12));
}

TEST_CASE("a path through the stretched arm stops at a drive singularity, at the time it is reached") {
  // straight through the outer border of the workspace at x = 0.9
  const RunResult result = run(arm(R"(
assembly: {J2: 1}
motion: {duration: 1, samples: 101, from: {tool: [0.5, 0]}, to: {tool: [1.1, 0]}}
trajectories: {out: {law: uniform, drive: tool}}
)"));
  CHECK(result.outcome.status == MotionStatus::drive_singularity);
  CHECK(result.outcome.time == doctest::Approx(0.4 / 0.6).epsilon(1e-5));
  CHECK(result.time.size() == 0);
}

TEST_CASE("a start beyond reach is unreachable, loops that cannot close are not assembled") {
  CHECK(run(arm("motion: {duration: 1, from: {tool: [2, 0]}, to: {tool: [0.5, 0]}}")).outcome.status ==
        MotionStatus::unreachable);
  const std::string open_loop = R"(
space: planar
ground: {points: {A: [0, 0], D: [5, 0]}}
bodies:
  a: {mass: 1, com: [0, 0], inertia: 1, points: {A: [0, 0], B: [1, 0]}}
  b: {mass: 1, com: [0, 0], inertia: 1, points: {B: [0, 0], C: [1, 0]}}
  c: {mass: 1, com: [0, 0], inertia: 1, points: {C: [0, 0], D: [1, 0]}}
joints:
  A: {type: revolute, connects: [ground.A, a.A]}
  B: {type: revolute, connects: [a.B, b.B]}
  C: {type: revolute, connects: [b.C, c.C]}
  D: {type: revolute, connects: [c.D, ground.D]}
actuators: [A]
motion: {duration: 1, from: {joints: {A: 0}}, to: {joints: {A: 1}}}
)";
  const RunResult result = run(open_loop);
  CHECK(result.outcome.status == MotionStatus::not_assembled);
  CHECK(result.outcome.reason.find(" m at best") != std::string::npos);
}

TEST_CASE("coarse samples give the same values as fine ones: steps are divided until they stay on the assembly mode") {
  const std::string motion = R"(
assembly: {J2: 1}
motion: {duration: 1, samples: SAMPLES, from: {tool: [0.8, 0.1]}, to: {tool: [-0.6, 0.3]}}
)";
  const auto with = [&](const char* samples) {
    std::string text = motion;
    return run(arm(text.replace(text.find("SAMPLES"), 7, samples)));
  };
  const RunResult coarse = with("5"), fine = with("4001");
  REQUIRE(coarse.outcome.status == MotionStatus::done);
  for (int k = 0; k < 5; ++k) {
    CHECK(coarse.joint_position(k, 1) == doctest::Approx(fine.joint_position(1000 * k, 1)).epsilon(1e-10));
    CHECK(coarse.torque(k, 0) == doctest::Approx(fine.torque(1000 * k, 0)).epsilon(1e-9));
  }
}

TEST_CASE("too few actuators are refused, too many share the effort with least norm") {
  std::string one = arm("motion: {duration: 1, from: {joints: {J1: 0, J2: 1}}, to: {joints: {J1: 1, J2: 1}}}");
  one.replace(one.find("[J1, J2]"), 8, "[J1]");
  const RunResult under = run(one);
  CHECK(under.outcome.status == MotionStatus::mismatch);
  CHECK(under.outcome.reason.find("under-actuated: 1 actuators for 2") != std::string::npos);

  const RunResult over = run(R"(
space: planar
ground: {points: {A: [0, 0], D: [1, 0]}}
bodies:
  a: {mass: 1, com: [0, 0], inertia: 1, points: {A: [0, 0], B: [0, 1]}}
  b: {mass: 1e-9, com: [0.5, 0], inertia: 1e-9, points: {B: [0, 0], C: [1, 0]}}
  c: {mass: 1, com: [0, 0], inertia: 1, points: {D: [0, 0], C: [0, 1]}}
joints:
  A: {type: revolute, connects: [ground.A, a.A]}
  B: {type: revolute, connects: [a.B, b.B]}
  C: {type: revolute, connects: [b.C, c.C]}
  D: {type: revolute, connects: [ground.D, c.D]}
actuators: [A, D]
motion: {duration: 1, samples: 11, from: {joints: {A: 0.3}}, to: {joints: {A: 1}}}
)");
  REQUIRE(over.outcome.status == MotionStatus::done);
  REQUIRE(over.outcome.notes.size() == 1);
  CHECK(over.outcome.notes[0].find("over-actuated") == 0);
  // two equal cranks of a parallelogram turn alike: each motor takes half of 2 kg m^2 times the acceleration
  CHECK(over.torque(2, 0) == doctest::Approx(over.joint_acceleration(2, 0)).epsilon(1e-6));
  CHECK(over.torque(2, 1) == doctest::Approx(over.torque(2, 0)).epsilon(1e-6));
}
