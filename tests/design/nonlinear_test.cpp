#include "mechanisms.hpp"
#include "objectives.hpp"

#include <doctest/doctest.h>

#include <cmath>

using namespace design_tests;

TEST_CASE("mass and place of a counterweight are found together") {
  const auto design = problem(
      {{"cw.mass", 0, 10, 1}, {"cw.at", -0.5, 0, -0.1}},
      [](const VectorX& x) {
        Mechanism m = planar_arm({0.5}, {2});
        m.attachments = {counterweight("cw", 1, x[1], 0, x[0])};
        return m;
      },
      GoalKind::statics);
  const DesignOutcome outcome = solve_design(design);
  REQUIRE(outcome.status == DesignStatus::balanced);
  CHECK(outcome.method == DesignMethod::polynomial);
  CHECK(outcome.x[0] * outcome.x[1] == doctest::Approx(-0.5).epsilon(1e-13));
  CHECK(outcome.residuals_after.cwiseAbs().maxCoeff() < 1e-15);
}

TEST_CASE("the lightest counterweight hangs as far out as it may") {
  auto design = problem(
      {{"cw.mass", 0, 10, 1}, {"cw.at", -0.5, 0, -0.1}},
      [](const VectorX& x) {
        Mechanism m = planar_arm({0.5}, {2});
        m.attachments = {counterweight("cw", 1, x[1], 0, x[0])};
        return m;
      },
      GoalKind::statics);
  design.objective = sum_of(design.model->build_mechanism(VectorX::Zero(2)), dynamics::ParameterOwner::attachment, "m");
  for (const std::string method : {"auto", "slsqp", "auglag", "cobyla", "bobyqa", "sbplx"}) {
    CAPTURE(method);
    design.search.local = method;
    const DesignOutcome outcome = solve_design(design);
    REQUIRE(outcome.status == DesignStatus::balanced);
    // searches stop at changes of 1e-13, those without gradients sooner
    CHECK(outcome.objective == doctest::Approx(1).epsilon(1e-4));
    CHECK(outcome.residuals_after.cwiseAbs().maxCoeff() < 1e-14);
    CHECK(within_bounds(design, outcome.x));
    CHECK(outcome.optimality == Optimality::local_optimum);  // not convex: nothing is claimed
  }
}

TEST_CASE("the best of a curved set of exact solutions is the one that a scan finds") {
  // two links; counterweights of free mass and place: places x1, x2 determine the masses
  auto design = problem(
      {{"cw1.at", -0.3, -0.05, -0.1}, {"cw1.mass", 0, 80, 1}, {"cw2.at", -0.3, -0.05, -0.1}, {"cw2.mass", 0, 80, 1}},
      [](const VectorX& x) {
        Mechanism m = planar_arm({0.5, 0.4}, {2, 1});
        m.attachments = {counterweight("cw1", 1, x[0], 0, x[1]), counterweight("cw2", 2, x[2], 0, x[3])};
        return m;
      },
      GoalKind::statics);
  // total mass and, weighted, moments of inertia of the counterweights: neither end of the bounds is best
  Objective objective;
  objective.function = of_parameters([](const VectorX& p,
                                        VectorX* gradient) {  // two links, then m, mx, my, J of each counterweight
    if (gradient != nullptr)
      *gradient =
          VectorX::Unit(16, 8) + VectorX::Unit(16, 12) + 30 * VectorX::Unit(16, 11) + 30 * VectorX::Unit(16, 15);
    return p[8] + p[12] + 30 * (p[11] + p[15]);
  });
  design.objective = objective;
  const DesignOutcome outcome = solve_design(design);
  REQUIRE(outcome.status == DesignStatus::balanced);
  double best = INFINITY;
  const int steps = 1000;
  for (int i = 0; i <= steps; ++i)
    for (int k = 0; k <= steps; ++k) {
      const double x1 = -0.3 + 0.25 * i / steps, x2 = -0.3 + 0.25 * k / steps;
      const double m2 = -0.2 / x2, m1 = -(2 * 0.25 + 0.5 * (1 + m2)) / x1;
      best = std::min(best, m1 + m2 + 30 * (m1 * x1 * x1 + m2 * x2 * x2));
    }
  // the scan misses the minimum by the square of its step, in a function whose second derivative is about 2 m / x^2
  CHECK(outcome.objective <= best + 1e-9);
  CHECK(outcome.objective == doctest::Approx(best).epsilon(1e-4));
}

TEST_CASE("a solution that is the only one is the best one, whatever the objective") {
  auto design = problem(
      {{"crank.com", -0.2, 0.2, 0.05}, {"rod.com", -0.3, 0.3, 0.15}},
      [](const VectorX& x) {
        Mechanism m = slider_crank();
        m.bodies[1].com[0] = x[0];
        m.bodies[2].com[0] = x[1];
        return m;
      },
      GoalKind::force);
  design.objective = sum_of(design.model->build_mechanism(VectorX::Zero(2)), dynamics::ParameterOwner::body, "J", true);
  design.objective->is_convex = false;
  const DesignOutcome outcome = solve_design(design);
  REQUIRE(outcome.status == DesignStatus::balanced);
  CHECK(outcome.optimality == Optimality::proved_global);
  CHECK(outcome.lower_bound == outcome.objective);
}

TEST_CASE("the softest spring is the one with the longest lever, and objectives see the caller's parameters") {
  // k y a = m g l; the spring's end and its stiffness are free, the objective knows of stiffnesses only
  auto design = problem(
      {{"k", 0, 5000, 100}, {"s.y", 0, 1, 0.1}},
      [](const VectorX& x) {
        Mechanism m = planar_arm({0.5}, {2});
        m.springs = {Spring{"s", 0, 1, {0, x[1], 0}, {0.2, 0, 0}, x[0], 0}};
        return m;
      },
      GoalKind::statics);
  Objective softest;
  softest.function = of_parameters([](const VectorX& p, VectorX* gradient) {
    REQUIRE(p.size() == 5);  // m, mx, my, J, k
    if (gradient != nullptr) *gradient = VectorX::Unit(5, 4);
    return p[4];
  });
  design.objective = softest;
  const DesignOutcome outcome = solve_design(design);
  REQUIRE(outcome.status == DesignStatus::balanced);
  CHECK(outcome.x[1] == 1);
  CHECK(outcome.objective == doctest::Approx(2 * 9.81 * 0.25 / 0.2).epsilon(1e-9));
}

TEST_CASE("a number in an expression that is no polynomial still leads to an exact solution") {
  const auto design = problem(
      {{"p", 0.5, 3, 1}},
      [](const VectorX& x) {
        Mechanism m = planar_arm({0.5}, {2});
        m.attachments = {counterweight("cw", 1, -0.3 * std::exp(-x[0]), 0, 1 / (0.1 + x[0]))};
        return m;
      },
      GoalKind::statics);
  DesignProblem lighter = design;
  lighter.model = model_of([](const VectorX& x) {
    Mechanism m = planar_arm({0.5}, {0.4});
    m.attachments = {counterweight("cw", 1, -0.3 * std::exp(-x[0]), 0, 1 / (0.1 + x[0]))};
    return m;
  });
  const DesignOutcome outcome = solve_design(lighter);
  REQUIRE(outcome.status == DesignStatus::balanced);
  CHECK(0.3 * std::exp(-outcome.x[0]) / (0.1 + outcome.x[0]) == doctest::Approx(0.1).epsilon(1e-12));
  // with the heavier link 0.5 kg m would be needed, and 0.3 at most is there
  CHECK(solve_design(design).status == DesignStatus::compromise);
}
