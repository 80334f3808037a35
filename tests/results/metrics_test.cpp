/// Figures of a run do not depend on how few samples are kept of it, and numbers that overflow are no figures.

#include "balance/interface/specification/read_spec.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/synthesis/verification/simulate_natural.hpp"

#include <doctest/doctest.h>

#include <cmath>

using namespace balance;

namespace {

/// A mass on a slide, moved to and fro against its own inertia alone.
constexpr const char* block = R"(
space: planar
ground: {points: {O: [0, 0]}}
bodies: {block: {mass: 2, com: [0, 0], inertia: 1}}
joints: {S: {type: prismatic, connects: [ground.O, block.origin]}}
actuators: [S]
motion: {duration: 0.5, samples: 2, from: {joints: {S: 0}}, to: {joints: {S: 0.3}}}
trajectories:
  cubic: {law: cubic, drive: joints}
)";

RunResult run(Study study, const std::string& name, long samples, bool natural = false) {
  for (Trajectory& trajectory : study.trajectories) {
    if (trajectory.name != name) continue;
    trajectory.samples = samples;
    return natural ? verification::simulate_natural(study.mechanism, trajectory)
                   : simulate(study.mechanism, trajectory);
  }
  FAIL("no trajectory " << name);
  return {};
}

const Metric& metric(const RunResult& result, const std::string& quantity) {
  for (const Metric& one : result.metrics)
    if (one.quantity == quantity) return one;
  FAIL("no metric " << quantity);
  return result.metrics.front();
}

}  // namespace

TEST_CASE("the energy moved by a motor is that of the motion, however few samples are kept (A6)") {
  // cubic law over a stroke d in T: the largest speed is 3 d / 2 T, and the motor first gives and then takes m v² / 2
  const double speed = 1.5 * 0.3 / 0.5, energy = 2 * speed * speed;
  const double force = 2 * 6 * 0.3 / (0.5 * 0.5);
  const Study study = read_spec(block, "block.yaml");
  for (const bool natural : {false, true}) {
    for (const long samples : {2L, 3L, 4L, 7L, 50L, 401L, 1000L}) {
      const RunResult result = run(study, "cubic", samples, natural);
      REQUIRE(result.outcome.status == MotionStatus::done);
      CHECK(result.time.size() == samples);
      CHECK(result.energy == doctest::Approx(energy).epsilon(2e-5));  // trapezoids of 400 steps: 1 / 400²
      CHECK(metric(result, "kinetic_energy").peak == doctest::Approx(energy / 2).epsilon(2e-5));
      CHECK(metric(result, "shaking_force").peak == doctest::Approx(force).epsilon(1e-12));
      CHECK(metric(result, "shaking_force").rms == doctest::Approx(force / std::sqrt(3)).epsilon(2e-5));
    }
  }
}

TEST_CASE("samples keep their places in time whatever lies between them (A6)") {
  const Study study = read_spec(block, "block.yaml");
  const RunResult few = run(study, "cubic", 5), many = run(study, "cubic", 4 * 500 + 1);
  for (Eigen::Index k = 0; k < 5; ++k) {
    CHECK(few.time[k] == many.time[500 * k]);
    CHECK(few.joint_position(k, 0) == many.joint_position(500 * k, 0));
  }
}

TEST_CASE("figures that the samples of a quick motion cannot carry are noted (A6)") {
  constexpr const char* crank = R"(
space: planar
ground: {points: {O: [0, 0]}}
bodies: {crank: {mass: 1, com: [0.1, 0], inertia: 0.01}}
gravity: [0, -9.81]
joints: {J: {type: revolute, connects: [ground.O, crank.origin]}}
actuators: [J]
motion: {duration: 1, from: {joints: {J: 0}}, to: {joints: {J: TURNS}}}
trajectories: {turn: {law: cycloidal, drive: joints}}
)";
  const auto noted = [&](const std::string& end, const std::string& law) {
    std::string text = crank;
    text.replace(text.find("TURNS"), 5, end);
    text.replace(text.find("cycloidal"), 9, law);
    const RunResult result = run(read_spec(text, "crank.yaml"), "turn", 1001);
    REQUIRE(result.outcome.status == MotionStatus::done);
    for (const std::string& note : result.outcome.notes)
      if (note.find("use more samples") != std::string::npos) return true;
    return false;
  };
  CHECK_FALSE(noted("1", "cycloidal"));
  CHECK_FALSE(noted("20 * pi", "uniform"));
  CHECK(noted("2000 * pi", "cycloidal"));
  CHECK(noted("2000 * pi", "uniform"));  // every sample at the same angle: nothing else would show it
}

TEST_CASE("numbers beyond what can be computed with end a run with their name and time (A7)") {
  Study study = read_spec(block, "block.yaml");
  study.mechanism.bodies.back().mass = 1e300;  // as a program may build it
  const RunResult result = run(study, "cubic", 101);
  REQUIRE(result.outcome.status == MotionStatus::overflow);
  CHECK(result.outcome.reason.find("numbers overflow at t = ") == 0);
  CHECK(result.metrics.empty());
  const RunResult natural = run(study, "cubic", 101, true);  // may find it out earlier
  CHECK(natural.outcome.status != MotionStatus::done);
  CHECK(natural.metrics.empty());
}
