#pragma once
/// A mass that a motor pushes along a line: every law has a closed form.

#include "balance/motion/time_optimal/resolve_trajectory.hpp"

namespace balance {

struct SliderOptions {
  double mass = 2, gravity = 0, viscous = 0, coulomb = 0;
};

/// Along x; gravity pulls towards −x.
inline Mechanism make_slider(const SliderOptions& o) {
  Mechanism m;
  m.name = "slider";
  m.space = SpaceKind::planar;
  m.gravity = Vector3(-o.gravity, 0, 0);
  m.bodies.push_back({.name = "ground"});
  m.bodies.push_back({.name = "block", .mass = o.mass});
  m.bodies.back().inertia(2, 2) = 0.1;
  m.bodies.back().points.push_back({"P", Vector3::Zero()});
  Joint joint{.name = "D", .type = JointType::prismatic, .first = 0, .second = 1};
  joint.axis = Vector3::UnitX();
  m.joints.push_back(joint);
  m.coordinates = list_coordinates(m.space, m.joints);
  m.actuators = {0};
  m.tool = Tool{1, "P", Vector3::Zero()};
  if (o.viscous != 0 || o.coulomb != 0) m.friction.push_back({0, o.viscous, o.coulomb});
  return m;
}

inline Trajectory slide(double distance, const std::vector<trajectory::MotionLimit>& limits) {
  Trajectory t;
  t.name = "slide";
  t.law.kind = MotionLawKind::time_optimal;
  t.drive = DriveKind::joints;
  t.limits = limits;
  t.from.joints = {{0, 0}};
  t.to.joints = {{0, distance}};
  return t;
}

}  // namespace balance
