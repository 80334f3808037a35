#include "balance/interface/specification/read_spec.hpp"
#include "balance/synthesis/conditions/spec_symbols.hpp"

#include <doctest/doctest.h>

using namespace balance;

namespace {

/// An arm whose numbers come from parameters in every way that there is.
std::string spec(const std::string& parameters, const std::string& more = "") {
  return "space: planar\ngravity: [0, -9.81]\n" + more + "parameters: " + parameters + R"(
ground: {points: {O: [0, 0]}}
bodies:
  link1: {mass: m1, com: [0.1, 0], inertia: 0.1, points: {A: [0, 0], B: [l1, 0]}}
  link2: {mass: 1, com: [0.1, 0], inertia: 0.1, points: {B: [0, 0], C: ["l2 / 2", "0.25"], D: ["l1 + l2", 0]}}
  link3: {mass: 1, com: [0.1, 0], inertia: 0.1, points: {C: [0, 0]}}
  link4: {mass: 1, com: [0.1, 0], inertia: 0.1, points: {D: [0, 0]}}
discs: {d: {on: link1, at: [0.1, 0], follows: J2, ratio: beta, mass: 0.1, inertia: 0.01}}
joints:
  J1: {type: revolute, connects: [ground.O, link1.A]}
  J2: {type: revolute, connects: [link1.B, link2.B]}
  J3: {type: revolute, connects: [link2.C, link3.C]}
  J4: {type: revolute, connects: [link2.D, link4.D]}
actuators: [J1, J2, J3, J4]
)";
}

const std::string parameters = "{l1: 0.5, l2: 0.4, m1: 2, beta: \"-(m1 + 0.02) / 0.2\"}";

/// "l1 = 0.5 m: link1.B.x; …", one line per symbol.
std::string listed(const std::string& text, const ReadOptions& options = {}) {
  std::string lines;
  for (const conditions::GeometricSymbol& s : conditions::list_symbols(read_design_space(text, "arm.yaml", options))) {
    lines += s.label + " = " + std::to_string(s.value).substr(0, 7) + " " + s.unit + ":";
    for (const conditions::GeometricSymbol::Use& use : s.uses)
      lines += " " + use.number.label + (use.exponent == 1 ? "" : "^" + std::to_string(use.exponent));
    lines += "\n";
  }
  return lines;
}

}  // namespace

TEST_CASE("numbers are named by the parameters that they are multiples of, or by their place") {
  CHECK(listed(spec(parameters)) ==
        "l1 = 0.50000 m: link1.B.x\n"
        "l2 = 0.40000 m: link2.C.x\n"
        // An expression over masses is not taken apart: its own name stands for it.
        "beta = -10.100 1: d.ratio\n"
        "link2.C.y = 0.25000 m: link2.C.y\n"
        // A sum of parameters is neither of them.
        "link2.D.x = 0.90000 m: link2.D.x\n"
        "d.at.x = 0.10000 m: d.at.x\n"
        "g = 9.81000 m/s^2: g\n");
}

TEST_CASE("symbols are in SI whatever the spec's units, and follow overrides") {
  const std::string text = spec("{l1: 500, l2: 400, m1: 2, beta: -3}", "units: {length: mm}\n");
  const std::string lines = listed(text, {{{"l2", "200"}, {"beta", "-m1"}}});
  CHECK(lines.find("l1 = 0.50000 m: link1.B.x\n") != std::string::npos);
  CHECK(lines.find("l2 = 0.20000 m: link2.C.x\n") != std::string::npos);
  // Set to a multiple of a plain number, the ratio is that number's multiple.
  CHECK(lines.find("m1 = 2.00000 1: d.ratio\n") != std::string::npos);
}

TEST_CASE("free parameters are names too; products of parameters are made of both") {
  const std::string text = spec("{l1: {free: [0.1, 1], start: 0.5}, k: 0.8, l2: \"l1 * k\", m1: 2, beta: -3}");
  const std::string lines = listed(text);
  CHECK(lines.find("l1 = 0.50000 m: link1.B.x link2.C.x\n") != std::string::npos);
  CHECK(lines.find("k = 0.80000 1: link2.C.x\n") != std::string::npos);
}

TEST_CASE("a parameter called g does not lend its name to gravity") {
  const std::string lines = listed(spec("{l1: 0.5, l2: 0.4, m1: 2, beta: -3, g: 7}"));
  CHECK(lines.find("gravity = 9.81000 m/s^2: g\n") != std::string::npos);
}

TEST_CASE("a study without its expressions still has the names of places") {
  DesignSpace space;
  space.start = read_spec(spec(parameters), "arm.yaml");
  CHECK(conditions::list_symbols(space).size() == conditions::list_geometric_symbols(space.start.mechanism).size());
}
