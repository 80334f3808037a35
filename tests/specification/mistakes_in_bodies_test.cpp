#include "specs.hpp"

TEST_CASE("a body must be one that can exist and is connected") {
  const specs::Mistake in_planar[] = {
      {"mass: 1, com", "mass: 0, com",
       "s.yaml:10:17: bodies.lower.mass: must be positive: expected a number > 0, found 0"},
      {"mass: 1, com: [k, 0],", "mass: -1, com: [k, 0],",
       "s.yaml:10:17: bodies.lower.mass: must be positive: expected a number > 0, found -1"},
      {"mass: 1, com: [k, 0],", "com: [k, 0],",
       "s.yaml:10:10: bodies.lower: missing key: expected 'mass', found only com, inertia and points"},
      {"mass: 1, com: [k, 0],", "mass: 1,",
       "s.yaml:10:10: bodies.lower: missing key: expected 'com', found only mass, inertia and points"},
      {"inertia: 0.01, points", "points",
       "s.yaml:10:10: bodies.lower: missing key: expected 'inertia', found only mass, com and points"},
      {"inertia: 0.001}\njoints", "inertia: -1}\njoints",
       "s.yaml:11:44: bodies.wheel.inertia: no body can have this inertia: expected a positive one about its CoM, "
       "found -1 kg m^2"},
      {"inertia: 0.01,", "inertia: {about: origin, value: 0.01},",
       "s.yaml:10:42: bodies.lower.inertia: no body can have this inertia: expected a positive one about its CoM, "
       "found -0.0525 kg m^2"},
      {"inertia: 0.01,", "inertia: {about: tip, value: 0.1},",
       "s.yaml:10:50: bodies.lower.inertia.about: expected the point that the inertia is about (com or origin), found "
       "'tip'"},
      {"inertia: 0.01,", "inertia: [1, 2, 3],",
       "s.yaml:10:42: bodies.lower.inertia: expected a number, an expression or {free: [lower, upper]}, found a list "
       "of 3"},
      {"H: [l, 0]", "H: [l]", "s.yaml:10:71: bodies.lower.points.H: expected [x, y], found a list of 1"},
      {"H: [l, 0]", "H..x: [l, 0]",
       "s.yaml:10:68: bodies.lower.points.H..x: expected a name of letters, digits, '_' and '-', found 'H..x'"},
      {"  wheel:", "  ground:",
       "s.yaml:11:3: bodies.ground: expected a name other than 'ground', which is the body that does not move; "
       "define its points under 'ground:'"},
      {"  wheel: {", "  spare: {mass: 1, com: [0, 0], inertia: 1}\n  wheel: {",
       "s.yaml:11:3: bodies.spare: unused body: expected a joint that connects it, found none"},
      {"joints:\n",
       "  left: {mass: 1, com: [0, 0], inertia: 1}\n  right: {mass: 1, com: [0, 0], inertia: 1}\njoints:\n  X: {type: "
       "fixed, connects: [left.origin, right.origin]}\n",
       "s.yaml:12:3: bodies.left: disconnected: expected a chain of joints from the ground to this body, found none"},
  };
  specs::check(specs::planar, in_planar);
  const specs::Mistake in_spatial[] = {
      {"[0.02, 0.02, 0.01], points", "[0.02, 0.02, 0.05], points",
       "s.yaml:6:43: bodies.a.inertia: no body can have this inertia: expected no principal moment above"},
      {"[0.02, 0.02, 0.01], points", "[0.02, 0.02, 0], points",
       "s.yaml:6:43: bodies.a.inertia: no body can have this inertia: expected a positive definite matrix,"},
      {"[0.02, 0.02, 0.01], points", "[0.02, 0.02], points",
       "s.yaml:6:43: bodies.a.inertia: expected [Ixx, Iyy, Izz] or [Ixx, Iyy, Izz, Ixy, Ixz, Iyz], found a list of 2"},
      {"0.01, 0.001, 0, 0]", "0.01, 0.03, 0, 0]",
       "s.yaml:7:43: bodies.b.inertia: no body can have this inertia: expected a positive definite matrix,"},
  };
  specs::check(specs::spatial, in_spatial);
}

TEST_CASE("a joint must be of its space and connect two points") {
  const specs::Mistake in_planar[] = {
      {"type: pin-slot", "type: revolut",
       "s.yaml:15:13: joints.D.type: expected a joint type of a planar mechanism (revolute, prismatic,"},
      {"type: pin-slot", "type: spherical",
       "s.yaml:15:13: joints.D.type: expected a joint type of a planar mechanism (revolute, prismatic,"},
      {"[upper.B, lower.B]", "[upper.B, lower.C]",
       "s.yaml:14:44: joints.J2.connects[1]: expected a point of lower (B, H or origin), found 'C'"},
      {"[upper.B, lower.B]", "[uper.B, lower.B]",
       "s.yaml:14:35: joints.J2.connects[0]: expected a body (ground, upper, lower or wheel), found 'uper'; nearest is "
       "'upper'"},
      {"[upper.B, lower.B]", "[upper.B, lower]",
       "s.yaml:14:44: joints.J2.connects[1]: expected a point, body.point, found 'lower'; the body's own frame is "
       "'lower.origin'"},
      {"[upper.B, lower.B]", "[upper.B, upper.A]",
       "s.yaml:14:34: joints.J2.connects: expected points of two bodies, found two points of 'upper'"},
      {"[upper.B, lower.B]", "[upper.B]",
       "s.yaml:14:34: joints.J2.connects: expected two points [body.point, body.point], found a list of 1"},
      {"[upper.B, wheel.origin]", "[upper.B, wheel.origin], axis: [0, 0]",
       "s.yaml:15:64: joints.D.axis: expected a direction, found zero"},
      {"[upper.B, lower.B]}", "[upper.B, lower.B], axis: [1, 0]}",
       "s.yaml:14:60: joints.J2.axis: expected no axis: this type of joint has none in a planar mechanism"},
      {"[upper.B, lower.B]}", "[upper.B, lower.B], rpy: [0, 0, 1]}",
       "s.yaml:14:59: joints.J2.rpy: expected 'angle' for a planar joint, found a rotation in space"},
  };
  specs::check(specs::planar, in_planar);
  const specs::Mistake in_spatial[] = {
      {"axis2: [0, 1, 0], rpy", "axis2: [1, 1, 0], rpy",
       "s.yaml:10:70: joints.U.axis2: expected a direction perpendicular to 'axis', found an angle of 45 degrees"},
      {", axis2: [0, 1, 0], rpy", ", rpy",
       "s.yaml:10:52: joints.U.axis: expected both 'axis' and 'axis2' of a universal joint, found only one of "
       "them"},
      {"rpy: [0.1, 0, 0]", "rpy: [0.1, 0, 0], quaternion: [1, 0, 0, 0]",
       "s.yaml:10:111: joints.U.quaternion: expected 'rpy' or 'quaternion', found both"},
      {"rpy: [0.1, 0, 0]", "quaternion: [0, 0, 0, 0]",
       "s.yaml:10:93: joints.U.quaternion: expected a quaternion [w, x, y, z] that is not zero, found zero"},
      {"rpy: [0.1, 0, 0]", "angle: 1",
       "s.yaml:10:88: joints.U.angle: expected 'rpy' or 'quaternion' for a joint in space, found 'angle'"},
      {"type: revolute", "type: pin-slot",
       "s.yaml:9:13: joints.R.type: expected a joint type of a spatial mechanism (revolute, prismatic,"},
  };
  specs::check(specs::spatial, in_spatial);
}
