#include "specs.hpp"

TEST_CASE("the first mistake in a document is reported with its place") {
  const specs::Mistake in_planar[] = {
      {"name: test arm", "name: [test", "s.yaml:1:7: expected YAML, found a syntax error: '[' is not closed"},
      {"name: test arm", "nam: test arm",
       "s.yaml:1:1: nam: unknown key: expected name, space, gravity, parameters, units, include, ground, bodies,"},
      {"gravity: [0, -9.81]", "gravity: [0, -9.81]\ngravity: [0, 0]",
       "s.yaml:4:1: gravity: expected each key only once, found 'gravity' again"},
      {"mass: 1, com", "mass: 1, mass: 2, com",
       "s.yaml:10:20: bodies.lower.mass: expected each key only once, found 'mass' again"},
      {"space: planar\n", "",
       "s.yaml:1:1: missing key: expected 'space', found only name, gravity, parameters, units, ground,"},
      {"space: planar", "space: flat",
       "s.yaml:2:8: space: expected the kind of space (planar or spatial), found 'flat'"},
      {"bodies:", "bodeis:",
       "s.yaml:8:1: bodeis: unknown key: expected name, space, gravity, parameters, units, include, ground, bodies,"},
      {"gravity: [0, -9.81]", "gravity: -9.81", "s.yaml:3:10: gravity: expected [x, y], found '-9.81'"},
      {"gravity: [0, -9.81]", "gravity: [0, 0, -9.81]", "s.yaml:3:10: gravity: expected [x, y], found a list of 3"},
      {"gravity: [0, -9.81]", "gravity: [0, down]",
       "s.yaml:3:14: gravity[1]: expected a number or an expression, found 'down': there is no parameter 'down'"},
      {"gravity: [0, -9.81]", "gravity: [0, .nan]", "s.yaml:3:14: gravity[1]: expected a finite number, found '.nan'"},
      {"gravity: [0, -9.81]", "gravity: [0, 1e999]",
       "s.yaml:3:14: gravity[1]: expected a finite number, found '1e999'"},
      {"gravity: [0, -9.81]", "gravity: [0, \"1/0\"]",
       "s.yaml:3:14: gravity[1]: expected a finite number, found '1/0'"},
      {"gravity: [0, -9.81]", "gravity: [0, true]",
       "s.yaml:3:14: gravity[1]: expected a number, an expression or {free: [lower, upper]}, found 'true'"},
      {"gravity: [0, -9.81]", "gravity: [0, ]", "s.yaml:3:10: gravity: expected [x, y], found a list of 1"},
  };
  specs::check(specs::planar, in_planar);
}

TEST_CASE("expressions, free numbers, parameters and units that make no sense are named") {
  const specs::Mistake in_planar[] = {
      {"com: [k, 0], inertia: 0.02", "com: [\"k +\", 0], inertia: 0.02",
       "s.yaml:9:26: bodies.upper.com[0]: expected a number or an expression, found 'k +': a value is missing at "
       "its end"},
      {"com: [k, 0], inertia: 0.02", "com: [\"sinn(k)\", 0], inertia: 0.02",
       "s.yaml:9:26: bodies.upper.com[0]: expected a number or an expression, found 'sinn(k)': there is no function "
       "'sinn'; nearest is 'sin'"},
      {"com: [k, 0], inertia: 0.02", "com: [\"2 * L\", 0], inertia: 0.02",
       "s.yaml:9:26: bodies.upper.com[0]: expected a number or an expression, found '2 * L': there is no parameter "
       "'L'; nearest is 'l'"},
      {"com: [k, 0], inertia: 0.02", "com: [\"k, 2\", 0], inertia: 0.02",
       "s.yaml:9:26: bodies.upper.com[0]: expected a number or an expression, found 'k, 2': it has more than one "
       "value"},
      {"mass: {free: [0, 10]}", "mass: {free: [10, 0]}",
       "s.yaml:26:47: counterweights.cw.mass.free: expected lower < upper, found [10, 0]"},
      {"mass: {free: [0, 10]}", "mass: {free: [0, 10], start: 11}",
       "s.yaml:26:40: counterweights.cw.mass: expected a start between 0 and 10, found 11"},
      {"mass: {free: [0, 10]}", "mass: {free: 10}",
       "s.yaml:26:47: counterweights.cw.mass.free: expected [lower, upper], found '10'"},
      {"mass: {free: [0, 10]}", "mass: {free: [-1, 10]}",
       "s.yaml:26:40: counterweights.cw.mass: must not be negative: expected a number ≥ 0, found -1"},
      {"mass: {free: [0, 10]}", "mass: {fre: [0, 10]}",
       "s.yaml:26:41: counterweights.cw.mass.fre: unknown key: expected free, start or step, found 'fre'; nearest is "
       "'free'"},
      {"m: 2, k: \"l / 2\"", "m: \"k + 1\", k: \"m / 2\"",
       "s.yaml:4:25: parameters.m: expected a parameter that does not depend on itself, found the cycle m → k → m"},
      {"k: \"l / 2\"", "k: \"l / b\"",
       "s.yaml:4:31: parameters.k: expected a number or an expression, found 'l / b': there is no parameter 'b'"},
      {"k: \"l / 2\"", "k: \"k\"",
       "s.yaml:4:31: parameters.k: expected a parameter that does not depend on itself, found the cycle k → k"},
      {"k: \"l / 2\"", "pi: 3, k: 1",
       "s.yaml:4:28: parameters.pi: expected an unused name, found 'pi', which has a meaning in expressions"},
      {"k: \"l / 2\"", "l2..x: 3, k: 1",
       "s.yaml:4:28: parameters.l2..x: expected a name of letters, digits and '_', found 'l2..x'"},
      {"length: m", "length: inch",
       "s.yaml:5:17: units.length: expected a unit of length (m, dm, cm, mm, um, km, in or ft), found 'inch'"},
      {"length: m", "lenght: m",
       "s.yaml:5:9: units.lenght: unknown key: expected length, mass, time, angle or force, found 'lenght'; nearest is "
       "'length'"},
      {"angle: rad", "angle: 3",
       "s.yaml:5:27: units.angle: expected a unit of angle (rad, mrad, deg or turn), found '3'"},
  };
  specs::check(specs::planar, in_planar);
}
