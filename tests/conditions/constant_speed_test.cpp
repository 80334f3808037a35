/// Conditions at constant speed, of single components and about named points, solved by hand.

#include "balance/interface/specification/read_spec.hpp"
#include "balance/synthesis/conditions/condition_text.hpp"
#include "balance/synthesis/conditions/conditions.hpp"

#include <doctest/doctest.h>

#include <string>
#include <vector>

namespace constant_speed_test {

using namespace balance;
using namespace balance::conditions;

namespace {

using Texts = std::vector<std::string>;

Conditions derive(const std::string& spec, const std::string& goal) {
  return derive_conditions(read_spec(spec, "s.yaml").mechanism, {study::find_goal(goal).value()});
}

Texts rows(const std::string& spec, const std::string& goal) {
  CAPTURE(goal);
  const Conditions conditions = derive(spec, goal);
  CHECK_MESSAGE(conditions.status == ConditionsStatus::done, conditions.reason);
  Texts all;
  for (Eigen::Index row = 0; row < conditions.rank; ++row)
    all.push_back(linear_combination_text(conditions.parameters, conditions.matrix.row(row)));
  return all;
}

const std::string shaft_in_space = R"(
space: spatial
ground: {points: {O: [0, 0, 0], M: [0, 0, 2]}}
bodies: {shaft: {mass: 1, com: [0.1, 0, 0.5], inertia: [1, 1, 1], points: {O: [0, 0, 0]}}}
joints: {S: {type: revolute, connects: [ground.O, shaft.O], axis: [0, 0, 1]}}
actuators: [S]
)";

const std::string shaft_in_the_plane = R"(
space: planar
ground: {points: {O: [0, 0], M: [1, 0]}}
bodies: {shaft: {mass: 1, com: [0.1, 0], inertia: 1, points: {O: [0, 0]}}}
joints: {S: {type: revolute, connects: [ground.O, shaft.O]}}
actuators: [S]
)";

const std::string two_shafts = R"(
space: planar
ground: {points: {O: [0, 0], M: [1, 0]}}
bodies:
  a: {mass: 1, com: [0.1, 0], inertia: 1, points: {O: [0, 0]}}
  b: {mass: 1, com: [0.1, 0], inertia: 1, points: {M: [0, 0]}}
joints:
  A: {type: revolute, connects: [ground.O, a.O]}
  B: {type: revolute, connects: [ground.M, b.M]}
actuators: [A, B]
)";

const std::string slide = R"(
space: planar
ground: {points: {O: [0, 0]}}
bodies: {cart: {mass: 1, com: [0, 1], inertia: 1, points: {O: [0, 0]}}}
joints: {X: {type: prismatic, connects: [ground.O, cart.O], axis: [1, 0]}}
actuators: [X]
)";

Conditions derive_for_file(const std::string& file, const std::string& goal) {
  const Mechanism mechanism = read_spec_file(std::string(BALANCE_CONFIGS "/") + file).mechanism;
  return derive_conditions(mechanism, {study::find_goal(goal).value()});
}

bool are_equal(const Conditions& a, const Conditions& b) {
  return a.rank == b.rank && a.pivots == b.pivots && (a.matrix - b.matrix).cwiseAbs().maxCoeff() < 1e-9;
}

}  // namespace

TEST_CASE(
    "a shaft that turns uniformly shakes its frame unless the axis is a principal axis through its centre of mass") {
  // L = m c' and H = I w along a fixed direction: constant where m x = m y = 0 and I_xz = I_yz = 0
  CHECK(rows(shaft_in_space, "constant-speed-dynamic") == Texts{"shaft.mx", "shaft.my", "shaft.Ixz", "shaft.Iyz"});
  CHECK(rows(shaft_in_space, "constant-speed-force") == Texts{"shaft.mx", "shaft.my"});
  CHECK(rows(shaft_in_space, "constant-speed-moment") == Texts{"shaft.Ixz", "shaft.Iyz"});
  // one component turns into the other
  CHECK(rows(shaft_in_space, "constant-speed-moment[x]") == Texts{"shaft.Ixz", "shaft.Iyz"});
  CHECK(rows(shaft_in_space, "constant-speed-force[y]") == Texts{"shaft.mx", "shaft.my"});
  CHECK(rows(shaft_in_space, "constant-speed-moment[z]").empty());
  CHECK(rows(shaft_in_space, "constant-speed-force[z]").empty());
}

TEST_CASE("with any acceleration a shaft must have no moment of inertia about its axis, which nothing has") {
  CHECK(rows(shaft_in_space, "dynamic") == Texts{"shaft.mx", "shaft.my", "shaft.Izz", "shaft.Ixz", "shaft.Iyz"});
  CHECK(rows(shaft_in_space, "moment[z]") == Texts{"shaft.Izz"});
  CHECK(rows(shaft_in_space, "moment[x]") == Texts{"shaft.Ixz", "shaft.Iyz"});
  CHECK(rows(shaft_in_the_plane, "moment") == Texts{"shaft.J"});
  CHECK(rows(shaft_in_the_plane, "dynamic") == Texts{"shaft.mx", "shaft.my", "shaft.J"});
}

TEST_CASE("in the plane a shaft that turns uniformly has no moment about its bearing, and one about other points") {
  CHECK(rows(shaft_in_the_plane, "constant-speed-moment").empty());
  CHECK(rows(shaft_in_the_plane, "constant-speed-moment about ground.O").empty());
  CHECK(rows(shaft_in_the_plane, "constant-speed-moment about ground.M") == Texts{"shaft.mx", "shaft.my"});
  CHECK(rows(shaft_in_the_plane, "constant-speed-dynamic") == Texts{"shaft.mx", "shaft.my"});
  // along the axis the bearing may lie anywhere
  CHECK(rows(shaft_in_space, "constant-speed-moment about ground.M") ==
        Texts{"shaft.mx + 0.5 shaft.Ixz", "shaft.my + 0.5 shaft.Iyz"});
}

TEST_CASE("coordinates that are not at constant speed may accelerate") {
  CHECK(rows(two_shafts, "constant-speed-dynamic") == Texts{"a.mx", "a.my", "b.mx", "b.my"});
  CHECK(rows(two_shafts, "constant-speed-dynamic of A") == Texts{"a.mx", "a.my", "b.mx", "b.my", "b.J"});
  CHECK(rows(two_shafts, "constant-speed-dynamic of A and B") == rows(two_shafts, "constant-speed-dynamic"));
  CHECK(derive(two_shafts, "constant-speed-dynamic of A").notes ==
        Texts{"at constant speed: A; other freedoms may accelerate"});
}

TEST_CASE("a constant momentum need not be zero where a motion never returns") {
  CHECK(rows(slide, "force") == Texts{"cart.m"});
  CHECK(rows(slide, "force[x]") == Texts{"cart.m"});
  CHECK(rows(slide, "force[y]").empty());
  CHECK(rows(slide, "constant-speed-force").empty());
  CHECK(rows(slide, "constant-speed-dynamic").empty());
}

TEST_CASE(
    "where a crank turns fully and all else returns with it, forces at constant speed ask for the same as any forces") {
  for (const char* file : {"four-bar.yaml", "slider-crank.yaml", "whitworth.yaml", "parallelogram.yaml"}) {
    CAPTURE(file);
    CHECK(are_equal(derive_for_file(file, "constant-speed-force"), derive_for_file(file, "force")));
  }
}

TEST_CASE("the moment of a linkage at constant speed of its crank leaves the crank's own inertia free") {
  const Conditions moment = derive_for_file("four-bar.yaml", "dynamic"),
                   uniform = derive_for_file("four-bar.yaml", "constant-speed-dynamic");
  CHECK(uniform.rank == moment.rank - 1);
}

TEST_CASE("all components together are the whole") {
  const Mechanism mechanism = read_spec_file(BALANCE_CONFIGS "/spatial-slider-crank.yaml").mechanism;
  for (const std::string prefix : {"", "constant-speed-"})
    for (const std::string goal : {"force", "moment"}) {
      std::vector<Goal> components;
      for (const char* axis : {"[x]", "[y]", "[z]"})
        components.push_back(study::find_goal(prefix + goal + axis).value());
      CHECK(are_equal(derive_conditions(mechanism, components),
                      derive_conditions(mechanism, {study::find_goal(prefix + goal).value()})));
    }
}

TEST_CASE("a goal that the mechanism has no words for says so") {
  const auto reason = [](const std::string& spec, const std::string& goal) {
    const Conditions conditions = derive(spec, goal);
    CHECK(conditions.status == ConditionsStatus::mismatch);
    return conditions.reason;
  };
  CHECK(reason(shaft_in_space, "moment about ground.N") ==
        "the goal moment about ground.N: expected a point of the ground (ground.O, ground.M or "
        "ground.origin), found 'ground.N'; nearest is 'ground.O'");
  CHECK(reason(shaft_in_space, "moment about shaft.O").find("expected a point of the ground") != std::string::npos);
  CHECK(reason(shaft_in_space, "constant-speed-force of T") ==
        "the goal constant-speed-force of T: expected a coordinate (S), found 'T'");
  CHECK(reason(shaft_in_the_plane, "force[z]") ==
        "the goal force[z]: expected a component x or y in the plane, found 'force[z]'");
  CHECK(reason(shaft_in_the_plane, "moment[z]") ==
        "the goal moment[z]: expected no component, because the moment in the plane is a number, found 'moment[z]'");
  Mechanism four_bar = read_spec_file(BALANCE_CONFIGS "/four-bar.yaml").mechanism;
  four_bar.actuators.clear();
  const Goal goal{.kind = GoalKind::force, .is_at_constant_speed = true};
  CHECK(derive_conditions(four_bar, {goal})
            .reason.starts_with(
                "without actuators, a goal at constant speed of a mechanism with loops or constraints needs names of "
                "coordinates, as in constant-speed-force of "));
  four_bar.actuators = {0, 1};
  CHECK(derive_conditions(four_bar, {goal})
            .reason.starts_with("2 coordinates cannot all be at constant speed, because there is 1 degree of freedom"));
}

TEST_CASE("a goal's name means the goal, and its mistakes have words") {
  for (const char* name : {"force[y]", "moment[x]", "moment about ground.M", "moment[z] about ground.M",
                           "constant-speed-force", "constant-speed-moment[x]", "constant-speed-dynamic of A",
                           "constant-speed-moment[x] of A and B about ground.M"}) {
    CAPTURE(name);
    REQUIRE(study::find_goal(name));
    CHECK(goal_name(*study::find_goal(name)) == name);
  }
  CHECK(goal_name(study::find_goal(" force [ y ] ").value()) == "force[y]");
  CHECK(goal_name(study::find_goal("constant-speed-force of A and B and A").value()) ==
        "constant-speed-force of A and B");
  struct Case {
    const char *text, *mistake;
  };
  for (const Case& one : std::vector<Case>{
           {"force[w]", "expected a component x, y or z of the goal 'force', found 'w'"},
           {"dynamic[x]", "expected a goal of force or moment before the component [x], found 'dynamic'"},
           {"force of A",
            "expected a goal at constant speed (constant-speed-force, -moment or -dynamic) before 'of' "
            "coordinates, found 'force'"},
           {"constant-speed-force of ", "nearest is 'constant-speed-force'"},
           {"force about ground.M", "expected a goal of moment before 'about' and a point, found 'force'"},
           {"dynamic about ground.M", "without a shaking force the moment is the same about every point"},
           {"fully-force", "found 'fully-force'"},
           {"constant-speed-static", "found 'constant-speed-static'; nearest is 'constant-speed-"},
           {"constant-speed-momnt[x]", "nearest is 'constant-speed-moment'"}}) {
    CAPTURE(one.text);
    CHECK(!study::find_goal(one.text));
    CHECK_MESSAGE(study::explain_goal_mistake(one.text).sentence().find(one.mistake) != std::string::npos,
                  study::explain_goal_mistake(one.text).sentence());
  }
}

}  // namespace constant_speed_test
