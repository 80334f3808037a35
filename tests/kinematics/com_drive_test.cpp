// A centre of mass that stands still cannot drive anything, and that is what is said (A10).

#include "balance/interface/specification/read_spec.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <doctest/doctest.h>

#include <string>

namespace {

balance::MotionOutcome run(const std::string& text) {
  const balance::Study study = balance::read_spec(text, "com.yaml");
  return balance::simulate(study.mechanism, study.trajectories.front()).outcome;
}

bool says(const balance::MotionOutcome& outcome, const char* words) {
  return outcome.reason.find(words) != std::string::npos;
}

/// Crank 0.1, coupler 0.35, rocker 0.25, base 0.4. Half of the coupler's mass is carried by each of its neighbours, whose own
/// first moments make up for it (Berkof and Lowen 1969).
std::string four_bar(const char* crank_com, const char* rocker_com) {
  return std::string(R"(
name: four-bar
space: planar
gravity: [0, 0]
ground: {points: {O: [0, 0], P: [0.4, 0]}}
bodies:
  crank: {mass: 1, com: [)") +
         crank_com + R"(, 0], inertia: 0.01, points: {O: [0, 0], E: [0.1, 0]}}
  coupler: {mass: 1, com: [0.175, 0], inertia: 0.01, points: {O: [0, 0], E: [0.35, 0]}}
  rocker: {mass: 1, com: [)" +
         rocker_com + R"(, 0], inertia: 0.01, points: {O: [0, 0], E: [0.25, 0]}}
joints:
  A: {type: revolute, connects: [ground.O, crank.O]}
  B: {type: revolute, connects: [crank.E, coupler.O]}
  C: {type: revolute, connects: [coupler.E, rocker.E]}
  D: {type: revolute, connects: [ground.P, rocker.O]}
actuators: [A]
assembly: {A: 1.0, D: 1.8}
motion: {duration: 1, samples: 11, from: {joints: {A: 1.0}}, to: {joints: {A: 1.4}}}
trajectories: {go: {law: cubic, drive: com, components: [x]}}
)";
}

/// A cart on a rail along x that carries a wheel.
std::string cart(const char* wheel_com, const char* components, const char* rail = "[1, 0]") {
  return std::string(R"(
name: cart
space: planar
gravity: [0, 0]
ground: {points: {O: [0, 0]}}
bodies:
  cart: {mass: 2, com: [0, 0], inertia: 0.01, points: {O: [0, 0]}}
  wheel: {mass: 1, com: )") +
         wheel_com + R"(, inertia: 0.01, points: {O: [0, 0]}}
joints:
  X: {type: prismatic, connects: [ground.O, cart.O], axis: )" +
         rail + R"(}
  T: {type: revolute, connects: [cart.O, wheel.O]}
actuators: [X, T]
motion: {duration: 1, samples: 11, from: {joints: {X: 0, T: 0.3}}, to: {joints: {X: 0.1, T: 0.4}}}
trajectories: {go: {law: cubic, drive: com, )" +
         components + "}}\n";
}

}  // namespace

TEST_CASE("a force-balanced mechanism cannot be driven by its centre of mass, in those words (A10)") {
  const balance::MotionOutcome balanced = run(four_bar("-0.05", "-0.125"));
  CHECK(balanced.status == balance::MotionStatus::mismatch);
  CHECK(says(balanced,
             "the mechanism is force balanced: its centre of mass stands still and cannot drive it; use drive tool or "
             "joints"));
  // written with a few digits, as designs are
  CHECK(says(run(four_bar("-0.0500001", "-0.1249999")), "the mechanism is force balanced"));
  const balance::MotionOutcome other = run(four_bar("0.05", "0.125"));
  CHECK_MESSAGE(other.status == balance::MotionStatus::done, other.reason);
  CHECK_FALSE(says(run(four_bar("-0.05", "-0.12")), "force balanced"));
}

TEST_CASE("a centre of mass that cannot move in one direction is named with it (A10)") {
  const balance::MotionOutcome along_y = run(cart("[0, 0]", "components: [x, y]"));
  CHECK_MESSAGE(says(along_y, "force balanced along y: its centre of mass does not move in that direction"),
                along_y.reason);
  const balance::MotionOutcome slanted = run(cart("[0, 0]", "components: [x, y]", "[0.6, 0.8]"));
  CHECK_MESSAGE(says(slanted, "force balanced along [0.8, -0.6, 0]"), slanted.reason);
  const balance::MotionOutcome good = run(cart("[0.1, 0]", "components: [x, y]"));
  CHECK_MESSAGE(good.status == balance::MotionStatus::done, good.reason);
}
