#pragma once
/// Two complete specs, and a way to spoil them.

#include "balance/foundation/base/error.hpp"
#include "balance/interface/specification/read_spec.hpp"

#include <doctest/doctest.h>

#include <span>
#include <string>

namespace specs {

inline const std::string planar = R"(name: test arm
space: planar
gravity: [0, -9.81]
parameters: {l: 0.5, m: 2, k: "l / 2"}
units: {length: m, angle: rad}
ground:
  points: {O: [0, 0], S: [0, 1]}
bodies:
  upper: {mass: m, com: [k, 0], inertia: 0.02, points: {A: [0, 0], B: [l, 0]}}
  lower: {mass: 1, com: [k, 0], inertia: 0.01, points: {B: [0, 0], H: [l, 0]}}
  wheel: {mass: 0.2, com: [0, 0], inertia: 0.001}
joints:
  J1: {type: revolute, connects: [ground.O, upper.A]}
  J2: {type: revolute, connects: [upper.B, lower.B]}
  D: {type: pin-slot, connects: [upper.B, wheel.origin]}
couplings: [{joint: D.angle, follows: J2, ratio: -1}]
actuators: [J1, J2, D.slide]
tool: lower.H
assembly: {J1: 0.1, J2: 1}
motion: {duration: 1, samples: 101, from: {tool: [0.6, 0.1], angle: 1}, to: {tool: [0.1, 0.6], angle: 2}}
trajectories:
  line: {law: cubic, drive: tool}
  swing: {law: trapezoidal-velocity, ramp: 0.2, drive: joints, from: {joints: {J1: 0, J2: 1}}, to: {joints: {J1: 1, J2: 2}}}
  via: {law: 3-4-5, drive: tool, path: {waypoints: [{tool: [0.4, 0.4], angle: 1.5}], blend: spline, times: [0.4]}}
counterweights:
  cw: {on: upper, at: [-0.1, 0], mass: {free: [0, 10]}}
payloads:
  cargo: {on: lower, at: H, mass: 0.5, inertia: 0.001}
discs:
  disc: {on: upper, at: A, follows: J2, ratio: -2, mass: 0.3, inertia: 0.001}
loads:
  cut: {on: lower, at: H, force: [5, 0], moment: 1}
  tide: {on: lower, table: [[0, 1, 2], [1, 3, 4]]}
springs:
  s: {between: [ground.S, upper.B], stiffness: 100, free_length: 0.1}
friction: {J1: {viscous: 0.1, coulomb: 0.2}}
design: {goal: static, minimize: added-mass}
)";

inline const std::string spatial = R"(space: spatial
gravity: [0, 0, -9.81]
ground:
  points: {O: [0, 0, 0]}
bodies:
  a: {mass: 2, com: [0, 0, 0.1], inertia: [0.02, 0.02, 0.01], points: {P: [0, 0, 0.3]}}
  b: {mass: 1, com: [0, 0, 0.1], inertia: [0.02, 0.02, 0.01, 0.001, 0, 0], points: {Q: [0, 0, 0], H: [0, 0, 0.4]}}
joints:
  R: {type: revolute, connects: [ground.O, a.origin], axis: [0, 0, 1]}
  U: {type: universal, connects: [a.P, b.Q], axis: [1, 0, 0], axis2: [0, 1, 0], rpy: [0.1, 0, 0]}
actuators: [R, U.1, U.2]
tool: b.H
motion: {duration: 1, from: {tool: [0.1, 0, 0.6]}, to: {tool: [0.2, 0.1, 0.6]}}
trajectories:
  turn: {law: cycloidal, drive: tool, path: {circle: {centre: [0, 0, 0.6], normal: [0, 0, 1], turns: 1}}}
  bow: {law: cycloidal, drive: tool, path: {arc: {via: [0.2, 0, 0.6]}}}
discs:
  disc: {on: a, at: P, follows: U.1, mass: 0.1, inertia: {axial: 0.002, transverse: 0.001}}
loads:
  wind: {on: b, force: [1, 0, 0], moment: [0, 0, 1], frame: body}
)";

/// The text with its only occurrence of `find` replaced.
inline std::string with(std::string text, const std::string& find, const std::string& replace) {
  const auto at = text.find(find);
  REQUIRE_MESSAGE(at != std::string::npos, find);
  REQUIRE_MESSAGE(text.find(find, at + 1) == std::string::npos, find);
  return text.replace(at, find.size(), replace);
}

inline balance::Study read(const std::string& text, const balance::ReadOptions& options = {}) {
  return balance::read_spec(text, "s.yaml", options);
}

/// What read_spec complains about; empty if it does not.
inline std::string complaint(const std::string& text, const balance::ReadOptions& options = {}) {
  try {
    read(text, options);
  } catch (const balance::SpecError& error) {
    return error.what();
  }
  return "";
}

/// One mistake in a spec that is right otherwise.
struct Mistake {
  const char* find;
  const char* replace;
  const char* message;  ///< how the complaint begins
};

inline void check(const std::string& text, std::span<const Mistake> mistakes) {
  for (const Mistake& mistake : mistakes) {
    const std::string found = complaint(with(text, mistake.find, mistake.replace));
    INFO(mistake.replace);
    CHECK(found.substr(0, std::string(mistake.message).size()) == mistake.message);
  }
}

}  // namespace specs
