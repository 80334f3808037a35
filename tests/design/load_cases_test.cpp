// One design for several loads.

#include "load_cases.hpp"

using namespace load_cases;

TEST_CASE("what is left out is left out of all cases") {
  std::string text = replaced(pendulum, "motion:", "loads: {push: {body: link, at: E, force: [0, 3]}}\nmotion:");
  text = replaced(replaced(text, "for: {p: [0, 0.25, 1]}", "for: {p: [0, 1]}, adapt: cw"), "{p: 0}", "{p: 0.25}");
  const DesignSpace space = read(text);
  balance::DesignStudyOptions options;
  options.compare_trajectories = false;
  const DesignReport pushed = run_design_study(space, options);
  options.excluded = {"push"};
  const DesignReport left_out = run_design_study(space, options);
  CHECK(left_out.outcome.x[0] == doctest::Approx(1.25).epsilon(1e-9));
  CHECK(pushed.outcome.x[0] == doctest::Approx(1.25 - 3 / g).epsilon(1e-9));
}

TEST_CASE("a law that leaves the bounds is reported, and no number does") {
  const std::string far =
      replaced(replaced(rr, "for: {mp: [0, 0.5, 1]}", "for: {mp: [0, 100]}"), "mp: 0.5}", "mp: 50}");
  const DesignSpace space = read(far);
  const DesignReport report = find_design(space);
  CHECK(report.outcome.status == DesignStatus::infeasible);
  REQUIRE(report.adaptive->law);
  CHECK_FALSE(report.adaptive->is_within_bounds);
  CHECK(report.outcome.x.minCoeff() >= -1);
  CHECK(report.outcome.x.maxCoeff() <= -0.05);
}

TEST_CASE("places and masses together follow the load by a table") {
  std::string text = replaced(rr, "mass: 12", "mass: {free: [1, 50]}");
  text = replaced(text, "mass: 4", "mass: {free: [0.1, 50]}");
  text = replaced(text, "goal: static", "goal: static, minimize: added-mass");
  const DesignReport report = find_design(read(replaced(text, "adapt: [cw1.at, cw2.at]", "adapt: [cw1, cw2]")));
  CHECK(report.outcome.status == DesignStatus::balanced);
  REQUIRE(report.adaptive);
  CHECK_FALSE(report.adaptive->law);
  const balance::design::AdaptedTable& table = report.adaptive->table;
  REQUIRE(table.loads.size() == 17);
  for (std::size_t row = 0; row < table.loads.size(); ++row) {
    CHECK(table.residuals[row] < 1e-10);
    // the lightest one is as far out as may be
    const double load = table.loads[row][0];
    CHECK(table.values[row][2] == doctest::Approx(-1).epsilon(1e-6));
    CHECK(table.values[row][3] == doctest::Approx(0.3 + 0.4 * load).epsilon(1e-6));
  }
  CHECK_FALSE(report.adaptive->adjustment_work);  // masses do not come from nowhere
}

TEST_CASE("what cannot suit all loads suits them as well as can be") {
  const DesignReport squares = find_design(read(pendulum));
  CHECK(squares.outcome.status == DesignStatus::infeasible);
  CHECK(squares.outcome.is_proved_infeasible);
  CHECK(squares.outcome.x[0] == doctest::Approx(1 + 1.25 / 3).epsilon(1e-7));  // the loads' mean
  const std::string figure = "minimize: {peak: torque, along: cycloid}";
  const DesignReport worst = find_design(read(replaced(pendulum, "goal: static", figure)));
  CHECK(worst.outcome.x[0] == doctest::Approx(1.5).epsilon(1e-5));  // half-way between the extreme loads
  CHECK(worst.outcome.objective == doctest::Approx(0.25 * g).epsilon(1e-5));
  const DesignReport mean = find_design(read(replaced(pendulum, "goal: static", figure + ", across: mean")));
  CHECK(mean.outcome.x[0] == doctest::Approx(1.25).epsilon(1e-5));  // the loads' median
  CHECK(mean.outcome.objective == doctest::Approx(0.5 * g * (0.25 + 0.75) / 3).epsilon(1e-5));
}

TEST_CASE("lengths are found that suit all loads") {
  // a beam with 2 p at its left end and p at its right one: their common centre is at 0.3 m, where the pivot must be
  const DesignReport report = find_design(read(R"(
space: planar
gravity: [0, -9.81]
parameters: {p: 0.5, s: {free: [0.1, 0.8]}}
bodies:
  beam: {mass: 1, com: [0.45, 0], inertia: 0.05, points: {O: [s, 0], L: [0, 0], R: [0.9, 0]}}
payloads:
  left: {body: beam, at: L, mass: "2 * p"}
  right: {body: beam, at: R, mass: p}
counterweights: {cw: {body: beam, at: L, mass: {free: [0, 5]}}}
joints: {J: {type: revolute, connects: [ground.origin, beam.O]}}
actuators: [J]
motion: {duration: 1, samples: 11, from: {joints: {J: 0}}, to: {joints: {J: 1}}}
design: {goal: static, for: {p: [0, 1]}}
)"));
  CHECK(report.outcome.status == DesignStatus::balanced);
  CHECK(report.outcome.x[0] == doctest::Approx(0.3).epsilon(1e-9));
  CHECK(report.outcome.x[1] == doctest::Approx(0.5).epsilon(1e-9));
  for (const LoadCaseReport& one : report.load_cases) CHECK(one.residual < 1e-10);
}

TEST_CASE("cases may be listed one by one") {
  const DesignSpace space = read(
      replaced(rr, "for: {mp: [0, 0.5, 1]}", "for: [{mp: 0.2, \"cargo.at[0]\": 0.4}, {\"cargo.at[0]\": 0.3, mp: 1}]"));
  const balance::study::LoadCases& cases = space.start.design.cases;
  CHECK(cases.values.rows() == 2);
  CHECK(cases.values(1, 0) == 1);
  CHECK(cases.values(1, 1) == 0.3);
  CHECK(cases.numbers[1].path == "payloads.cargo.at[0]");
  CHECK(cases.numbers[1].nominal == 0.4);
}

TEST_CASE("goals that follow the centre of mass know no load cases") {
  CHECK_THROWS_AS(find_design(read(replaced(rr, "goal: static", "goal: affine"))), std::invalid_argument);
}
