// Where a run under control ends, and what it can do without.

#include "plant_cases.hpp"

#include "balance/motion/control/closed_loop_run.hpp"

using namespace plants;

namespace {

Study two_links(const std::string& more, const std::string& to = "tool: [2.1, 0.1]") {
  return read_spec(R"(
space: planar
gravity: [0, -9.81]
ground: {points: {O: [0, 0]}}
bodies:
  upper: {mass: 1, com: [0.5, 0], inertia: 0.08, points: {A: [0, 0], B: [1, 0]}}
  lower: {mass: 1, com: [0.5, 0], inertia: 0.08, points: {B: [0, 0], E: [1, 0]}}
joints:
  J1: {type: revolute, connects: [ground.O, upper.A]}
  J2: {type: revolute, connects: [upper.B, lower.B]}
tool: lower.E
controllers:
  inf: {type: computed-torque, kp: 1e308, kd: 1e308}
  free: {type: none}
  stated: {type: open-loop, torque: 5}
  pd: {type: pd}
  loop: {type: open-loop}
  smc: {type: sliding-mode}
motion: {duration: 1, samples: 51, from: {tool: [0.8, 0.2]}, to: {)" +
                       to + R"(}}
trajectories: {go: {law: cycloidal, drive: tool}}
)" + more,
                   "two.yaml");
}

RunResult led(const Study& study, const std::string& name, const ClosedLoopOptions& options = {}) {
  for (const Controller& controller : study.controllers)
    if (controller.name == name)
      return simulate_closed_loop(study.mechanism, study.trajectories.at(0), controller, options);
  FAIL("no controller " << name);
  return {};
}

const std::string motors = "actuators: [J1, J2]\n";

}  // namespace

TEST_CASE("without actuators every controller ends as simulate does, and what is let go moves (C1)") {
  const Study study = two_links("", "tool: [1.1, 0.3]");
  const RunResult simulated = simulate(study.mechanism, study.trajectories.at(0));
  REQUIRE(simulated.outcome.status == MotionStatus::mismatch);
  for (const std::string name : {"inf", "stated", "pd", "loop", "smc"}) {
    CAPTURE(name);
    const RunResult result = led(study, name);
    CHECK(result.outcome.status == MotionStatus::mismatch);
    CHECK(result.outcome.reason == simulated.outcome.reason);
  }
  CHECK(led(study, "free").outcome.status == MotionStatus::done);
}

TEST_CASE("gains beyond all numbers overflow, and are not taken for a singularity (A7)") {
  const RunResult result = led(two_links(motors, "tool: [1.1, 0.3]"), "inf");
  CHECK(result.outcome.status == MotionStatus::overflow);
  CHECK(result.outcome.reason.find("numbers overflow at t = ") == 0);
}

TEST_CASE("a run takes no more steps than it may (A8)") {
  const Study stiff = two_links(
      motors + "springs: {s: {between: [ground.O, lower.E], stiffness: 1e14, free_length: 1}}\n", "tool: [1.1, 0.3]");
  const RunResult result = led(stiff, "free", {.max_steps = 5000});
  CHECK(result.outcome.status == MotionStatus::unreachable);
  CHECK(result.outcome.reason.find("5000 steps") != std::string::npos);
  CHECK(led(two_links(motors, "tool: [1.1, 0.3]"), "free", {.max_steps = 5000}).outcome.status == MotionStatus::done);
}

TEST_CASE("free motion and stated torques need no desired motion, from the start of which they go (A5)") {
  for (const std::string to : {"tool: [2.1, 0.1]", "tool: [5, 5]"}) {
    CAPTURE(to);
    const Study study = two_links(motors, to);
    REQUIRE(simulate(study.mechanism, study.trajectories.at(0)).outcome.status != MotionStatus::done);
    for (const std::string name : {"free", "stated"}) {
      CAPTURE(name);
      const RunResult result = led(study, name);
      REQUIRE_MESSAGE(result.outcome.status == MotionStatus::done, result.outcome.reason);
      CHECK(result.time.size() == 51);
      CHECK(result.tracking_error.size() == 0);
      CHECK(result.tool_error.size() == 0);
      CHECK(std::abs(result.tool_position(0, 0) - 0.8) < 1e-12);
      CHECK(std::any_of(result.outcome.notes.begin(), result.outcome.notes.end(),
                        [](const std::string& note) { return note.find("no errors are reported") == 0; }));
      CHECK(std::none_of(result.metrics.begin(), result.metrics.end(),
                         [](const Metric& metric) { return metric.quantity.find("error") != std::string::npos; }));
    }
    for (const std::string name : {"pd", "loop"}) CHECK(led(study, name).outcome.status != MotionStatus::done);
  }
}

TEST_CASE("figures of a run under control do not depend on how many samples are kept (A6)") {
  Study study = two_links(motors, "tool: [1.1, 0.3]");
  Controller slow;
  for (const Controller& one : study.controllers)
    if (one.name == "pd") slow = one;
  slow.name = "slow", slow.period = 0.2, slow.kp = slow.kd = {};
  study.controllers.push_back(slow);
  for (const std::string name : {"free", "stated", "pd", "smc", "slow"}) {
    CAPTURE(name);
    study.trajectories.at(0).samples = 4001;
    const RunResult fine = led(study, name);
    REQUIRE_MESSAGE(fine.outcome.status == MotionStatus::done, fine.outcome.reason);
    for (const long samples : {2L, 11L, 50L}) {
      CAPTURE(samples);
      study.trajectories.at(0).samples = samples;
      const RunResult coarse = led(study, name);
      REQUIRE(coarse.metrics.size() == fine.metrics.size());
      CHECK(coarse.energy == doctest::Approx(fine.energy).epsilon(1e-3));
      for (std::size_t i = 0; i < fine.metrics.size(); ++i) {
        const Metric &a = fine.metrics[i], &b = coarse.metrics[i];
        CAPTURE(a.quantity);
        // what chatters does so between any two moments at which the controller samples
        const bool chatters = a.quantity.find("error") != std::string::npos || a.quantity.find("sliding") == 0;
        if (name == "smc" && chatters) continue;
        CHECK(std::abs(a.peak - b.peak) <= 1e-3 * a.peak);
        CHECK(std::abs(a.rms - b.rms) <= 1e-3 * a.peak);
        CHECK(std::abs(a.mean - b.mean) <= 1e-3 * a.peak);
      }
    }
  }
}
