#include "balance/synthesis/design/condition_dependence.hpp"
#include "balance/interface/specification/read_spec.hpp"

#include <doctest/doctest.h>

using namespace balance;
using namespace balance::design;

namespace {

/// Two links on a ceiling with everything free that can be; one number is in two places, one is of no account.
constexpr const char* text = R"(
space: planar
gravity: [0, -9.81]
parameters: {w: {free: [0, 2]}}
ground: {points: {O: [0, 0]}}
bodies:
  link1: {mass: 2, com: [{free: [-1, 1]}, 0], inertia: {free: [1, 2]}, points: {A: [0, 0], B: [{free: [0.2, 0.8]}, 0]}}
  link2: {mass: w, com: [0.1, {free: [-1, 1]}], inertia: 0.1, points: {B: [0, 0]}}
counterweights:
  c: {on: link2, at: [{free: [-1, 0]}, 0], mass: w}
joints:
  J1: {type: revolute, connects: [ground.O, link1.A]}
  J2: {type: revolute, connects: [link1.B, link2.B]}
actuators: [J1, J2]
)";

}  // namespace

TEST_CASE("a condition depends on the free numbers that its terms are made of, lengths included") {
  const DesignSpace space = read_design_space(text, "arm.yaml");
  const auto derive = [](const Mechanism& m) { return derive_conditions(m, {{GoalKind::statics}}); };
  const Conditions c = derive(space.start.mechanism);
  REQUIRE(c.status == ConditionsStatus::done);
  const auto occurring = probe_condition_variables(space, c, derive);
  std::vector<std::string> found;
  for (std::size_t row = 0; row < occurring.size(); ++row) {
    found.push_back(c.parameters[static_cast<std::size_t>(c.pivots[row])].name + ":");
    for (const int i : occurring[row])
      found.back() += " " + space.start.free_numbers[static_cast<std::size_t>(i)].key_path;
  }
  // The arm's static conditions by hand: m1 x1 + l (m2 + mc) = 0, m1 y1 = 0, m2 x2 + mc xc = 0, m2 y2 = 0.
  CHECK(found == std::vector<std::string>{"link1.mx: parameters.w bodies.link1.com[0] bodies.link1.points.B[0]",
                                          "link1.my:", "link2.mx: parameters.w counterweights.c.at[0]",
                                          "link2.my: parameters.w bodies.link2.com[1]"});
}

TEST_CASE("without free numbers nothing depends on any") {
  const DesignSpace space = read_design_space(R"(
space: planar
gravity: [0, -9.81]
ground: {points: {O: [0, 0]}}
bodies: {link: {mass: 2, com: [1, 0], inertia: 1, points: {A: [0, 0]}}}
joints: {J: {type: revolute, connects: [ground.O, link.A]}}
actuators: [J]
)",
                                              "arm.yaml");
  const auto derive = [](const Mechanism& m) { return derive_conditions(m, {{GoalKind::statics}}); };
  const auto occurring = probe_condition_variables(space, derive(space.start.mechanism), derive);
  CHECK(occurring == std::vector<std::vector<int>>(2));
}
