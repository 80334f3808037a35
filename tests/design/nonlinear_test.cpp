#include "mechanisms.hpp"
#include "objectives.hpp"

#include <doctest/doctest.h>

#include <random>

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
  const DesignOutcome outcome = solve(design);
  REQUIRE(outcome.status == DesignStatus::balanced);
  CHECK(outcome.method == DesignMethod::polynomial);
  CHECK(outcome.x[0] * outcome.x[1] == doctest::Approx(-0.5).epsilon(1e-13));
  CHECK(outcome.after.cwiseAbs().maxCoeff() < 1e-15);
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
  design.objective = sum_of(design.mechanism_at(VectorX::Zero(2)), Bearer::attachment, "m");
  for (const std::string method : {"auto", "slsqp", "auglag", "cobyla", "bobyqa", "sbplx"}) {
    CAPTURE(method);
    design.search.local = method;
    const DesignOutcome outcome = solve(design);
    REQUIRE(outcome.status == DesignStatus::balanced);
    // searches stop at changes of 1e-13, those without gradients sooner
    CHECK(outcome.objective == doctest::Approx(1).epsilon(1e-4));
    CHECK(outcome.after.cwiseAbs().maxCoeff() < 1e-14);
    CHECK(within_bounds(design, outcome.x));
    CHECK_FALSE(outcome.global);  // not convex: nothing is claimed
  }
}

TEST_CASE("discs decouple a planar RRR arm at P1's ratios, whatever its masses") {
  // P1 eq. 26 with massless discs at the joints, after the static conditions
  std::mt19937 random(4);
  const auto pick = [&](double a, double b) { return std::uniform_real_distribution<double>(a, b)(random); };
  for (int trial = 0; trial < 3; ++trial) {
    CAPTURE(trial);
    const double l1 = pick(0.3, 0.7), l2 = pick(0.3, 0.7), l3 = pick(0.3, 0.7);
    const double m1 = pick(4, 6), m2 = pick(2, 3), m3 = pick(0.5, 1);
    const double j4 = pick(0.01, 0.05), j5 = pick(0.05, 0.1), j6 = pick(0.01, 0.05), j7 = pick(0.05, 0.1);
    Mechanism arm = planar_arm({l1, l2, l3}, {m1, m2, m3});
    arm.discs = {disc("d4", 1, 0, 1, 1, 0, j4), disc("d5", 1, 0, 1, 1, 0, j5), disc("d6", 2, 0, 2, 1, 0, j6),
                 disc("d7", 2, 0, 2, 1, 0, j7)};
    const double i2 = arm.bodies[2].inertia(2, 2), i3 = arm.bodies[3].inertia(2, 2);
    const auto design = problem(
        {{"com1", -0.7, 0.7, 0.2},
         {"com2", -0.7, 0.7, 0.2},
         {"com3", -0.7, 0.7, 0.2},
         {"beta", -60, 0, -1},
         {"gamma", -60, 0, -1}},
        [arm](const VectorX& x) {
          Mechanism m = arm;
          for (std::size_t k = 0; k < 3; ++k) m.bodies[k + 1].com[0] = x[static_cast<Eigen::Index>(k)];
          m.discs[1].ratio = x[3];
          m.discs[3].ratio = x[4];
          return m;
        },
        GoalKind::decoupled);
    const DesignOutcome outcome = solve(design);
    REQUIRE(outcome.status == DesignStatus::balanced);
    CHECK(outcome.method == DesignMethod::geometric);
    const double beta = -(i2 + i3 + j4 + j6 + j7 + m3 * l2 * l2 + m3 * m3 * l2 * l2 / m2) / j5;
    const double gamma = -(i3 + j6) / j7;
    CHECK(outcome.x[0] == doctest::Approx(-l1 * (m2 + m3) / m1).epsilon(1e-10));
    CHECK(outcome.x[1] == doctest::Approx(-l2 * m3 / m2).epsilon(1e-10));
    CHECK(std::abs(outcome.x[2]) < 1e-11);
    CHECK(outcome.x[3] == doctest::Approx(beta).epsilon(1e-10));
    CHECK(outcome.x[4] == doctest::Approx(gamma).epsilon(1e-10));
    CHECK(judged(design, outcome.x) < met);
  }
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
  lighter.mechanism_at = [](const VectorX& x) {
    Mechanism m = planar_arm({0.5}, {0.4});
    m.attachments = {counterweight("cw", 1, -0.3 * std::exp(-x[0]), 0, 1 / (0.1 + x[0]))};
    return m;
  };
  const DesignOutcome outcome = solve(lighter);
  REQUIRE(outcome.status == DesignStatus::balanced);
  CHECK(0.3 * std::exp(-outcome.x[0]) / (0.1 + outcome.x[0]) == doctest::Approx(0.1).epsilon(1e-12));
  // with the heavier link 0.5 kg m would be needed, and 0.3 at most is there
  CHECK(solve(design).status == DesignStatus::compromise);
}
