// Numbers that follow the load: by hand, and by what is left over for loads that nobody asked for.

#include "load_cases.hpp"

using namespace load_cases;

TEST_CASE("the RR arm's counterweights follow the load by P0 eq. 95") {
  const DesignSpace space = read(rr);
  const DesignReport report = find_design(space);
  CHECK(report.outcome.status == DesignStatus::balanced);
  REQUIRE(report.adaptive);
  REQUIRE(report.adaptive->law);
  const AdaptiveLaw& law = *report.adaptive->law;
  // (m1 a1/2 + (m2 + cw2 + p) a1) / cw1 and (m2 a2/2 + p a2) / cw2
  CHECK(coefficient(law, 0, {0}) == doctest::Approx(-(1.0 * 0.5 + 5.5 * 0.5) / 12).epsilon(1e-12));
  CHECK(coefficient(law, 0, {1}) == doctest::Approx(-0.5 / 12).epsilon(1e-12));
  CHECK(coefficient(law, 1, {0}) == doctest::Approx(-0.3 / 4).epsilon(1e-12));
  CHECK(coefficient(law, 1, {1}) == doctest::Approx(-0.4 / 4).epsilon(1e-12));
  CHECK(law.terms.size() == 2);
  CHECK(law.is_affine(0));
  CHECK(report.adaptive->is_within_bounds);
  CHECK(report.adaptive->min_values[1] == doctest::Approx(-0.175).epsilon(1e-12));
  CHECK(report.adaptive->max_values[1] == doctest::Approx(-0.075).epsilon(1e-12));
  // the slopes against differences
  const VectorX here = VectorX::Constant(1, 0.3), there = VectorX::Constant(1, 0.4);
  CHECK((law.jacobian(here).col(0) * 0.1 - (law.evaluate(there) - law.evaluate(here))).norm() < 1e-14);
  check_random_loads(space, report);
}

TEST_CASE("a balance for half a kilogram leaves the difference's weight at the worst pose") {
  const DesignReport report = find_design(read(rr));
  REQUIRE(report.adaptive->fixed_design_cases.size() == 3);
  // both links level: 0.5 kg at 0.9 m from the first joint, at 0.4 m from the second; the climb ends within 1e-6 of it
  CHECK(resting(report.adaptive->fixed_design_cases[2], 0) == doctest::Approx(0.5 * 0.9 * g).epsilon(1e-6));
  CHECK(resting(report.adaptive->fixed_design_cases[2], 1) == doctest::Approx(0.5 * 0.4 * g).epsilon(1e-6));
  CHECK(resting(report.adaptive->fixed_design_cases[0], 0) == doctest::Approx(0.5 * 0.9 * g).epsilon(1e-6));
  for (const std::size_t joint : {0, 1}) {
    CHECK(resting(report.adaptive->fixed_design_cases[1], joint) < 1e-9);
    for (const LoadCaseReport& one : report.load_cases) CHECK(resting(one, joint) < 1e-9);
  }
}

TEST_CASE("moving the counterweights costs what their weight gains in height") {
  const std::string raised = replaced(rr, "from: {joints: {R1: 0, R2: 0}}", "from: {joints: {R1: 0.3, R2: 0.4}}");
  const DesignReport report = find_design(read(raised));
  REQUIRE(report.adaptive->adjustment_work);
  // from 0 to 1 kg cw1 goes 0.5/12 m towards −x of link1, cw2 0.1 m towards −x of link2
  const double work = -g * (12 * (0.5 / 12) * std::sin(0.3) + 4 * 0.1 * std::sin(0.7));
  CHECK(*report.adaptive->adjustment_work == doctest::Approx(work).epsilon(1e-9));
}

TEST_CASE("a load's mass and place come in as a product") {
  const DesignSpace space = read(
      replaced(rr, "for: {mp: [0, 0.5, 1]}", "for: {mp: [0, 1], \"cargo.at[0]\": {range: [0.2, 0.4], samples: 2}}"));
  const DesignReport report = find_design(space);
  CHECK(report.load_cases.size() == 4);
  REQUIRE(report.adaptive->law);
  const AdaptiveLaw& law = *report.adaptive->law;
  CHECK(coefficient(law, 1, {1, 1}) == doctest::Approx(-1.0 / 4).epsilon(1e-11));
  CHECK(std::abs(coefficient(law, 1, {1, 0})) < 1e-12);
  CHECK(coefficient(law, 0, {1, 0}) == doctest::Approx(-0.5 / 12).epsilon(1e-11));
  CHECK_FALSE(law.is_affine(1));
  check_random_loads(space, report);
}

TEST_CASE("a geared loop's counterweights follow the load") {
  const DesignSpace space = read(R"(
space: planar
gravity: [0, -9.81]
parameters: {base: 0.3, crank: 0.15, coupler: 0.3, p: 0}
ground:
  points: {A1: [0, 0], A2: [base, 0]}
bodies:
  crank1:   {mass: 0.7, com: [0.06, 0], inertia: 0.0015, points: {A: [0, 0], B: [crank, 0]}}
  coupler1: {mass: 0.9, com: [0.15, 0], inertia: 0.007, points: {B: [0, 0], P: [coupler, 0]}}
  crank2:   {mass: 0.7, com: [0.06, 0], inertia: 0.0015, points: {A: [0, 0], B: [crank, 0]}}
  coupler2: {mass: 0.9, com: [0.15, 0], inertia: 0.007, points: {B: [0, 0], P: [coupler, 0]}}
payloads: {cargo: {body: coupler1, at: P, mass: p}}
counterweights:
  c: {body: crank1, at: [{free: [-1, 0]}, 0], mass: 3}
  k: {body: coupler1, at: [{free: [-1, 0]}, 0], mass: 3}
joints:
  A1: {type: revolute, connects: [ground.A1, crank1.A]}
  B1: {type: revolute, connects: [crank1.B, coupler1.B]}
  A2: {type: revolute, connects: [ground.A2, crank2.A], angle: pi}
  B2: {type: revolute, connects: [crank2.B, coupler2.B]}
  P:  {type: revolute, connects: [coupler1.P, coupler2.P]}
couplings: [{joint: A2, follows: A1, ratio: -1}]
actuators: [A1]
assembly: {A1: 2.0, B1: -1.2, B2: 1.2}
motion: {duration: 0.5, samples: 11, from: {joints: {A1: 2.2}}, to: {joints: {A1: 0.9}}}
design: {goal: static, for: {p: [0, 1]}, adapt: [c, k]}
)");
  const DesignReport report = find_design(space);
  CHECK(report.outcome.status == DesignStatus::balanced);
  REQUIRE(report.adaptive);
  REQUIRE(report.adaptive->law);
  const AdaptiveLaw& law = *report.adaptive->law;
  // both halves move alike, so that their first moments add up: couplers, then cranks with all couplers at their ends
  CHECK(coefficient(law, 1, {0}) == doctest::Approx(-(2 * 0.9 * 0.15) / 3).epsilon(1e-9));
  CHECK(coefficient(law, 1, {1}) == doctest::Approx(-0.3 / 3).epsilon(1e-9));
  CHECK(coefficient(law, 0, {0}) == doctest::Approx(-(2 * 0.7 * 0.06 + (2 * 0.9 + 3) * 0.15) / 3).epsilon(1e-9));
  CHECK(coefficient(law, 0, {1}) == doctest::Approx(-0.15 / 3).epsilon(1e-9));
  check_random_loads(space, report, 10);
}

TEST_CASE("a spatial arm's counterweights follow the load") {
  const DesignSpace space = read(R"(
space: spatial
gravity: [0, 0, -9.81]
bodies:
  link1: {mass: 4, com: [0, 0, -0.1], inertia: [0.05, 0.04, 0.03], points: {B: [0, 0.3, 0]}}
  link2: {mass: 2, com: [0, 0.2, 0], inertia: [0.05, 0.01, 0.05], points: {C: [0, 0.4, 0]}}
  link3: {mass: 1, com: [0, 0.15, 0], inertia: [0.01, 0.002, 0.01], points: {E: [0, 0.3, 0]}}
payloads: {cargo: {body: link3, at: E, mass: 0.1}}
counterweights:
  cw2: {body: link2, at: [0, {free: [-0.5, 0]}, 0], mass: 20}
  cw3: {body: link3, at: [0, {free: [-0.5, 0]}, 0], mass: 5}
joints:
  J1: {type: revolute, connects: [ground.origin, link1.origin], axis: [0, 0, 1]}
  J2: {type: revolute, connects: [link1.B, link2.origin], axis: [1, 0, 0]}
  J3: {type: revolute, connects: [link2.C, link3.origin], axis: [1, 0, 0]}
actuators: [J1, J2, J3]
motion: {duration: 1, samples: 11, from: {joints: {J1: 0, J2: 0, J3: 0}}, to: {joints: {J1: 1, J2: 1, J3: 1}}}
design: {goal: static, for: {cargo.mass: {range: [0, 1], samples: 3}}, adapt: [cw2.at, "counterweights.cw3.at[1]"]}
)");
  const DesignReport report = find_design(space);
  CHECK(report.load_cases.size() == 3);
  REQUIRE(report.adaptive->law);
  const AdaptiveLaw& law = *report.adaptive->law;
  CHECK(coefficient(law, 0, {0}) == doctest::Approx(-(2 * 0.2 + 6 * 0.4) / 20).epsilon(1e-11));
  CHECK(coefficient(law, 0, {1}) == doctest::Approx(-0.4 / 20).epsilon(1e-11));
  CHECK(coefficient(law, 1, {0}) == doctest::Approx(-0.15 / 5).epsilon(1e-11));
  CHECK(coefficient(law, 1, {1}) == doctest::Approx(-0.3 / 5).epsilon(1e-11));
  // the answer's numbers suit the spec's own load, which is none of the cases
  CHECK(report.outcome.x[1] == doctest::Approx(-(0.15 + 0.3 * 0.1) / 5).epsilon(1e-11));
  check_random_loads(space, report);
}

TEST_CASE("the 5R's law passes through the lightest balance of its spec") {
  std::string text = replaced(file_text("5r-design.yaml"), "design: {goal: static, minimize: added-mass}",
                              "design: {goal: static, minimize: added-mass, for: {cargo.mass: [0, 0.6, 1.2]}, "
                              "adapt: [cw21, cw22]}");
  const DesignReport report = find_design(read(text));
  CHECK(report.outcome.optimality == balance::design::Optimality::proved_global);
  // its head has 2.625, 0, 8.872, 3.045 kg for 0.6 kg; leg 1 carries no more, whatever the load
  const double published[] = {2.625, 0, 8.872, 3.045};
  for (Eigen::Index i = 0; i < 4; ++i) CHECK(report.outcome.x[i] == doctest::Approx(published[i]).epsilon(1e-7));
  // the load hangs on leg 2 alone: a22/0.2 of it on coupler2, and what that weighs times a21/0.2 on crank2
  const AdaptiveLaw& law = *report.adaptive->law;
  CHECK(coefficient(law, 1, {1}) == doctest::Approx(0.42 / 0.2).epsilon(1e-9));
  CHECK(coefficient(law, 0, {1}) == doctest::Approx((1 + 0.42 / 0.2) * 0.32 / 0.2).epsilon(1e-9));
}
