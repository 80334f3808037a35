#include "specs.hpp"

TEST_CASE("couplings, actuators and the tool must refer to what is there") {
  const specs::Mistake in_planar[] = {
      {"joint: D.angle", "joint: D",
       "s.yaml:16:21: couplings[0].joint: expected one coordinate of joint D (D.slide or D.angle), found 'D'"},
      {"follows: J2, ratio: -1}", "follows: J3, ratio: -1}",
       "s.yaml:16:39: couplings[0].follows: expected a joint coordinate (J1, J2, D.slide or D.angle), found 'J3'; "
       "nearest is 'J1'"},
      {"follows: J2, ratio: -1}", "follows: J2, ratio: 0}",
       "s.yaml:16:50: couplings[0].ratio: expected a ratio other than 0 (a joint that does not move is 'fixed'), found "
       "0"},
      {"follows: J2, ratio: -1}", "follows: D.angle, ratio: -1}",
       "s.yaml:16:21: couplings[0].joint: circular coupling: expected couplings without a cycle, found that "
       "'D.angle' follows itself"},
      {"ratio: -1}]", "ratio: -1}, {joint: J2, follows: D.angle, ratio: 2}]",
       "s.yaml:16:63: couplings[1].joint: circular coupling: expected couplings without a cycle, found that "
       "'J2' follows itself"},
      {"ratio: -1}]", "ratio: -1}, {joint: D.angle, follows: J1, ratio: 2}]",
       "s.yaml:16:63: couplings[1].joint: expected a coordinate that follows only one other, found 'D.angle', which is "
       "coupled twice"},
      {"actuators: [J1, J2, D.slide]", "actuators: [J1, J2, J1]",
       "s.yaml:17:21: actuators[2]: expected each actuator only once, found 'J1' again"},
      {"actuators: [J1, J2, D.slide]", "actuators: [J1, j2]",
       "s.yaml:17:17: actuators[1]: expected a joint coordinate (J1, J2, D.slide or D.angle), found 'j2'; nearest is "
       "'J2'"},
      {"actuators: [J1, J2, D.slide]", "actuators: J1",
       "s.yaml:17:12: actuators: expected a list of joint coordinates, found 'J1'"},
      {"tool: lower.H", "tool: lower.G", "s.yaml:18:7: tool: expected a point of lower (B, H or origin), found 'G'"},
      {"tool: lower.H", "tool: ground.O", "s.yaml:18:7: tool: expected a point of a moving body, found 'ground.O'"},
      {"assembly: {J1: 0.1", "assembly: {J0: 0.1",
       "s.yaml:19:12: assembly.J0: expected a joint coordinate (J1, J2, D.slide or D.angle), found 'J0'; nearest is "
       "'J1'"},
  };
  specs::check(specs::planar, in_planar);
}

TEST_CASE("a motion must say how long, from where and to where") {
  const specs::Mistake in_planar[] = {
      {"duration: 1,", "duration: 0,",
       "s.yaml:20:20: motion.duration: must be positive: expected a number > 0, found 0"},
      {"samples: 101", "samples: 1",
       "s.yaml:20:32: motion.samples: expected a whole number from 2 to 100000000, found '1'"},
      {"samples: 101", "samples: 10.5",
       "s.yaml:20:32: motion.samples: expected a whole number from 2 to 100000000, found '10.5'"},
      {"duration: 1, samples", "samples",
       "s.yaml:22:9: trajectories.line: missing key: expected 'duration' here or in 'motion', found none"},
      {"from: {tool: [0.6, 0.1], angle: 1}, ", "",
       "s.yaml:22:9: trajectories.line: missing key: expected 'from' here or in 'motion', found none"},
      {"to: {tool: [0.1, 0.6], angle: 2}", "to: {tool: [0.1, 0.6]}",
       "s.yaml:20:77: motion.to: expected the same quantities in all poses of a trajectory, found one with and one "
       "without 'angle'"},
      {"to: {tool: [0.1, 0.6], angle: 2}", "to: {}",
       "s.yaml:20:77: motion.to: expected a pose {tool: …}, {joints: …} or {com: …}, found an empty mapping"},
      {"to: {tool: [0.1, 0.6], angle: 2}", "to: {tool: [0.1, 0.6], rpy: [0, 0, 2]}",
       "s.yaml:20:96: motion.to.rpy: unknown key: expected tool, joints, com or angle, found 'rpy'"},
      {"tool: lower.H\n", "",
       "s.yaml:19:50: motion.from.tool: expected a spec with a tool ('tool: body.point'), found none; this key "
       "refers to the tool's pose"},
  };
  specs::check(specs::planar, in_planar);
}

TEST_CASE("a trajectory must give what its law, drive and path need") {
  const specs::Mistake in_planar[] = {
      {"law: cubic", "law: cubik",
       "s.yaml:22:15: trajectories.line.law: expected a law of motion (cycloidal, cycloid, bang-bang,"},
      {"drive: tool}\n  swing", "drive: tol}\n  swing",
       "s.yaml:22:29: trajectories.line.drive: expected a drive (joints, tool, com or none), found 'tol'; nearest is "
       "'tool'"},
      {"line: {law: cubic, drive: tool}", "line: {law: cubic}",
       "s.yaml:22:9: trajectories.line: missing key: expected 'drive', found only law"},
      {"line: {law: cubic, drive: tool}", "line: {law: cubic, ramp: 0.2, drive: tool}",
       "s.yaml:22:28: trajectories.line.ramp: expected no ramps: only the law 'trapezoidal-velocity' has them"},
      {"ramp: 0.2", "ramp: 0.6",
       "s.yaml:23:44: trajectories.swing.ramp: expected ramps > 0 with a sum of at most 1, found 0.6 and 0.6"},
      {"to: {joints: {J1: 1, J2: 2}}", "to: {joints: {J1: 1}}",
       "s.yaml:23:100: trajectories.swing.to: expected a value of 'J2' as in the trajectory's other poses, found none"},
      {"times: [0.4]", "times: [1.4]",
       "s.yaml:24:109: trajectories.via.path.times[0]: expected increasing times between 0 and the duration (1 s), "
       "found 1.4 s"},
      {"times: [0.4]", "times: [0.4, 0.5]",
       "s.yaml:24:108: trajectories.via.path.times: expected a list of 1, one time for each waypoint, found 2"},
      {"blend: spline", "blend: smooth",
       "s.yaml:24:93: trajectories.via.path.blend: expected a way to pass the waypoints (rest or spline), found "
       "'smooth'"},
      {"tool: [0.4, 0.4], angle: 1.5", "tool: [0.4, 0.4]",
       "s.yaml:24:53: trajectories.via.path.waypoints[0]: expected the same quantities in all poses of a trajectory, "
       "found one with and one without 'angle'"},
      {"line: {law: cubic, drive: tool}", "line: {drive: tool, path: {table: [[0, 0, 0], [1, 1, 1]]}}",
       "s.yaml:22:37: trajectories.line.path.table: expected at least 4 rows, found 2"},
      {"line: {law: cubic, drive: tool}",
       "line: {drive: tool, path: {table: [[0, 0, 0], [2, 1, 1], [1, 1, 1], [3, 1, 1]]}}",
       "s.yaml:22:37: trajectories.line.path.table: expected increasing times, found 1 s after 2 s in row 3"},
      {"line: {law: cubic, drive: tool}", "line: {drive: tool, path: {file: nowhere.csv}}",
       "s.yaml:22:36: trajectories.line.path.file: expected a file next to the spec, found none at 'nowhere.csv'"},
      {"line: {law: cubic, drive: tool}", "line: {law: cubic, drive: tool, components: [x, z]}",
       "s.yaml:22:51: trajectories.line.components[1]: expected a component (x, y or angle), found 'z'"},
      {"line: {law: cubic, drive: tool}", "line: {law: cubic, drive: com, remaining: [J9]}",
       "s.yaml:22:46: trajectories.line.remaining[0]: expected a joint coordinate (J1, J2, D.slide or D.angle), found "
       "'J9'; nearest is 'J1'"},
      {"line: {law: cubic, drive: tool}", "line: {law: cubic, drive: tool, path: {arc: {via: [0.35, 0.35]}}}",
       "s.yaml:22:53: trajectories.line.path.arc.via: expected a point off the line from start to end, found one on "
       "it"},
  };
  specs::check(specs::planar, in_planar);
  const specs::Mistake in_spatial[] = {
      {"centre: [0, 0, 0.6], normal", "normal",
       "s.yaml:15:54: trajectories.turn.path.circle: missing key: expected 'centre', found only normal and turns"},
      {"normal: [0, 0, 1], turns", "normal: [0, 0, 0], turns",
       "s.yaml:15:84: trajectories.turn.path.circle.normal: expected a direction, found zero"},
      {"turns: 1", "turns: 1, angle: 3",
       "s.yaml:15:112: trajectories.turn.path.circle.angle: expected 'angle' or 'turns', found both"},
  };
  specs::check(specs::spatial, in_spatial);
}
