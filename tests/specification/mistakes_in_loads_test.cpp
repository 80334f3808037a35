#include "specs.hpp"

TEST_CASE("what bodies carry must have a place and a possible inertia") {
  const specs::Mistake in_planar[] = {
      {"on: upper, at: [-0.1, 0]", "on: uppr, at: [-0.1, 0]",
       "s.yaml:26:12: counterweights.cw.on: expected a body (ground, upper, lower or wheel), found 'uppr'; nearest is "
       "'upper'"},
      {"on: upper, at: [-0.1, 0]", "on: ground, at: [-0.1, 0]",
       "s.yaml:26:12: counterweights.cw.on: expected a moving body, found the ground"},
      {"at: H, mass", "at: K, mass",
       "s.yaml:28:26: payloads.cargo.at: expected a point of lower (B, H or origin), found 'K'"},
      {"at: H, mass: 0.5", "at: H, mass: -0.5",
       "s.yaml:28:35: payloads.cargo.mass: must not be negative: expected a number ≥ 0, found -0.5"},
      {"inertia: 0.001}\ndiscs", "inertia: -0.001}\ndiscs",
       "s.yaml:28:49: payloads.cargo.inertia: no body can have this inertia: expected one that is not negative about "
       "its CoM, found -0.001 kg m^2"},
      {"follows: J2, ratio: -2", "follows: D, ratio: -2",
       "s.yaml:30:37: discs.disc.follows: expected one coordinate of joint D (D.slide or D.angle), found 'D'"},
      {"follows: J2, ratio: -2", "follows: J2, ratio: 0",
       "s.yaml:30:48: discs.disc.ratio: expected a ratio other than 0 (a disc that does not turn is a counterweight), "
       "found 0"},
      {"follows: J2, ratio: -2", "follows: J2, axis: [0, 0, 1]",
       "s.yaml:30:47: discs.disc.axis: expected no axis: a disc in the plane turns about z"},
  };
  specs::check(specs::planar, in_planar);
  const specs::Mistake in_spatial[] = {
      {"disc: {on: a, at: P, follows: U.1", "disc: {on: b, at: Q, follows: R",
       "s.yaml:18:9: discs.disc: missing key: expected 'axis', the direction about which the disc turns in"},
      {"{axial: 0.002, transverse: 0.001}", "{axial: 0.003, transverse: 0.001}",
       "s.yaml:18:58: discs.disc.inertia: no body can have this inertia: expected no principal moment above"},
  };
  specs::check(specs::spatial, in_spatial);
}

TEST_CASE("loads, springs, friction and goals must be complete") {
  const specs::Mistake in_planar[] = {
      {"force: [5, 0], moment: 1", "force: [5, 0], table: [[0, 1, 2]]",
       "s.yaml:32:8: loads.cut: expected one of: 'force' and 'moment' (constant), 'table', 'file'; found several"},
      {"force: [5, 0], moment: 1", "frame: world",
       "s.yaml:32:8: loads.cut: expected one of: 'force' and 'moment' (constant), 'table', 'file'; found none"},
      {"[1, 3, 4]]", "[1, 3]]", "s.yaml:33:40: loads.tide.table[1]: expected a row [time, fx, fy], found a list of 2"},
      {"[1, 3, 4]]", "[0, 3, 4]]",
       "s.yaml:33:28: loads.tide.table: expected increasing times, found 0 s after 0 s in row 2"},
      {"[ground.S, upper.B]", "[ground.S, ground.O]",
       "s.yaml:35:16: springs.s.between: expected points of two bodies, found two points of 'ground'"},
      {"stiffness: 100", "stiffness: -100",
       "s.yaml:35:48: springs.s.stiffness: must not be negative: expected a number ≥ 0, found -100"},
      {"friction: {J1", "friction: {J7",
       "s.yaml:36:12: friction.J7: expected a joint coordinate (J1, J2, D.slide or D.angle), found 'J7'; nearest is "
       "'J1'"},
      {"viscous: 0.1", "viscous: -0.1",
       "s.yaml:36:26: friction.J1.viscous: must not be negative: expected a number ≥ 0, found -0.1"},
      {"goal: static", "goal: statick",
       "s.yaml:37:16: design.goal: expected a goal (static, gyroscopic, gyroscopic-independent, decoupled,"},
  };
  specs::check(specs::planar, in_planar);
  const specs::Mistake in_spatial[] = {
      {"frame: body", "frame: tool", "s.yaml:20:61: loads.wind.frame: expected a frame (world or body), found 'tool'"},
  };
  specs::check(specs::spatial, in_spatial);
}
