#pragma once
/// Slider-cranks and four-bars side by side, whose singular configurations are known in closed form.

#include "balance/interface/specification/read_spec.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <cmath>
#include <cstddef>
#include <cstdio>
#include <string>
#include <vector>

namespace side_by_side {

/// Crank of length r about the origin, rod of length l to a slider on the line y = offset; a four-bar where `base` is not zero: crank
/// r, coupler l, rocker `rocker`, its pivot at (base, 0).
struct Part {
  double r = 0.1, l = 0.3, offset = 0, base = 0, rocker = 0;
  double from = 1, to = -1;  ///< of the crank [rad]

  bool four_bar() const { return base > 0; }

  /// The crank's angle at which crank and rod are stretched.
  double dead() const {
    if (!four_bar()) return std::asin(offset / (r + l));
    return std::acos((base * base + (r + l) * (r + l) - rocker * rocker) / (2 * base * (r + l)));
  }
  /// Slider's place or rocker's angle.
  double output(double crank) const {
    const double x = r * std::cos(crank), y = r * std::sin(crank);
    if (!four_bar()) return x + std::sqrt(l * l - (offset - y) * (offset - y));
    const double far = std::hypot(base - x, -y), along = std::atan2(-y, base - x);
    const double turn = std::acos((far * far + l * l - rocker * rocker) / (2 * far * l));
    return std::atan2(y + l * std::sin(along + turn), x + l * std::cos(along + turn) - base);
  }
};

inline std::string exact(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

inline std::string point(double x, double y, bool space) {
  return "[" + exact(x) + ", " + exact(y) + (space ? ", 0]" : "]");
}

inline std::string body(const std::string& name, double length, bool space) {
  const std::string inertia = space ? "[0.002, 0.002, 0.002]" : "0.002";
  return "  " + name + ": {mass: 1, com: " + point(length / 2, 0.01, space) + ", inertia: " + inertia +
         ", points: {O: " + point(0, 0, space) + ", E: " + point(length, 0, space) + "}}\n";
}

/// As many mechanisms side by side, all driven by their cranks.
/// @param at joints with a motor: X, the sliders and rockers, or A, the cranks, or both
inline std::string spec(const std::vector<Part>& parts, bool space, const std::string& way = "law: uniform",
                        const std::string& at = "X") {
  std::string ground, bodies, joints, motors, from, to, assembly;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const Part& part = parts[k];
    const std::string n = std::to_string(k), separator = k ? ", " : "";
    const double y = static_cast<double>(k);
    ground += "    O" + n + ": " + point(0, y, space) + "\n    P" + n + ": " +
              point(part.base, part.four_bar() ? y : y + part.offset, space) + "\n";
    bodies += body("c" + n, part.r, space) + body("r" + n, part.l, space) +
              body("s" + n, part.four_bar() ? part.rocker : 0.02, space);
    joints += "  A" + n + ": {type: revolute, connects: [ground.O" + n + ", c" + n + ".O]}\n";
    joints += "  B" + n + ": {type: revolute, connects: [c" + n + ".E, r" + n + ".O]}\n";
    if (part.four_bar()) {
      joints += "  C" + n + ": {type: revolute, connects: [r" + n + ".E, s" + n + ".E]}\n";
      joints += "  X" + n + ": {type: revolute, connects: [ground.P" + n + ", s" + n + ".O]}\n";
    } else {
      joints += "  C" + n + ": {type: revolute, connects: [r" + n + ".E, s" + n + ".O]}\n";
      joints += "  X" + n + ": {type: prismatic, connects: [ground.P" + n + ", s" + n +
                ".O], axis: " + point(1, 0, space) + "}\n";
    }
    for (const char joint : at) motors += (motors.empty() ? "" : ", ") + std::string(1, joint) + n;
    from += separator + "A" + n + ": " + exact(part.from);
    to += separator + "A" + n + ": " + exact(part.to);
    assembly += separator + "A" + n + ": " + exact(part.from) + ", X" + n + ": " + exact(part.output(part.from));
  }
  return std::string("name: parts\nspace: ") + (space ? "spatial" : "planar") + "\ngravity: " + point(0, -9.81, space) +
         "\nground:\n  points:\n" + ground + "bodies:\n" + bodies + "joints:\n" + joints + "actuators: [" + motors +
         "]\nmotion: {duration: 1, samples: 101, from: {joints: {" + from + "}}, to: {joints: {" + to +
         "}}}\ntrajectories: {go: {drive: joints, " + way + "}}\nassembly: {" + assembly + "}\n";
}

inline balance::MotionOutcome go(const balance::Study& study, long samples) {
  balance::Trajectory trajectory = study.trajectories.front();
  trajectory.samples = samples;
  return balance::simulate(study.mechanism, trajectory).outcome;
}

}  // namespace side_by_side
