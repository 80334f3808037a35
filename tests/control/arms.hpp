#pragma once
/// A one-joint arm whose motion can be told by hand, and runs of it and of the 5R.

#include "balance/interface/specification/read_spec.hpp"
#include "balance/motion/control/closed_loop_run.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <string>

namespace arms {

using namespace balance;

// The arm's inertia about its joint is 0.1 + 2 · 0.4² = 0.42 kg m² without and 0.74 kg m² with the cargo.
inline constexpr double own_inertia = 0.42, inertia = 0.74;
inline constexpr double own_moment = 2 * 0.4, cargo_moment = 0.5 * 0.8;  // [kg m]
inline constexpr double g = 9.81;

inline std::string arm_text(const std::string& controllers = "", const std::string& gravity = "-9.81") {
  return "space: planar\ngravity: [0, " + gravity + R"(]
ground: {points: {O: [0, 0]}}
bodies: {arm: {mass: 2, com: [0.4, 0], inertia: 0.1, points: {A: [0, 0], E: [0.8, 0]}}}
joints: {J: {type: revolute, connects: [ground.O, arm.A]}}
payloads: {cargo: {on: arm, at: E, mass: 0.5}}
actuators: [J]
tool: arm.E
motion: {duration: 1, samples: 201, from: {joints: {J: 0.2}}, to: {joints: {J: 1.2}}}
trajectories: {rest: {law: cycloidal, drive: joints, from: {joints: {J: 0.2}}, to: {joints: {J: 0.2}}}}
)" + controllers;
}

inline Study arm(const std::string& controllers = "", const std::string& gravity = "-9.81") {
  return read_spec(arm_text(controllers, gravity), "arm.yaml");
}

inline Study five_bar() { return read_spec_file(std::string(BALANCE_CONFIGS) + "/5r-balanced.yaml"); }

inline Trajectory make_trajectory(const Study& study, const std::string& name, long samples = 0) {
  for (Trajectory t : study.trajectories)
    if (t.name == name) {
      if (samples > 0) t.samples = samples;
      return t;
    }
  FAIL("no trajectory " << name);
  return {};
}

inline Controller controller(const Study& study, const std::string& name) {
  for (const Controller& c : study.controllers)
    if (c.name == name) return c;
  FAIL("no controller " << name);
  return {};
}

inline Controller controller(study::ControllerType type, double rate) {
  Controller c;
  c.name = controller_type_name(type);
  c.type = type;
  c.period = 1 / rate;
  return c;
}

inline VectorX all(long count, double value) { return VectorX::Constant(count, value); }

inline RunResult run(const Study& study, const std::string& name, const Controller& c, long samples = 0,
                     double settle = 0) {
  RunResult result =
      simulate_closed_loop(study.mechanism, make_trajectory(study, name, samples), c, {.hold_time = settle});
  CHECK_MESSAGE(result.outcome.status == MotionStatus::done, result.outcome.reason);
  return result;
}

inline const Metric& metric(const RunResult& result, const std::string& quantity) {
  for (const Metric& m : result.metrics)
    if (m.quantity == quantity) return m;
  FAIL("no metric " << quantity);
  return result.metrics.front();
}

/// Row of a sample at or just before a time.
inline long row(const RunResult& result, double time) {
  long k = 0;
  while (k + 1 < result.time.size() && result.time[k + 1] <= time + 1e-12) ++k;
  return k;
}

}  // namespace arms
