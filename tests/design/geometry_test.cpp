#include "mechanisms.hpp"
#include "objectives.hpp"

#include <doctest/doctest.h>

#include <random>

using namespace design_tests;

namespace {

/// P1 section 3.1 with massless discs at the joints; ratios of d5 and d7 are the numbers 3 and 4.
struct DiscArm {
  double l1, l2, l3, m1, m2, m3, j4, j5, j6, j7;

  Mechanism at(const VectorX& x) const {
    Mechanism m = planar_arm({l1, l2, l3}, {m1, m2, m3});
    for (std::size_t k = 0; k < 3; ++k) m.bodies[k + 1].com[0] = x[static_cast<Eigen::Index>(k)];
    m.discs = {disc("d4", 1, 0, 1, 1, 0, j4), disc("d5", 1, 0, 1, x[3], 0, j5), disc("d6", 2, 0, 2, 1, 0, j6),
               disc("d7", 2, 0, 2, x[4], 0, j7)};
    return m;
  }
  /// P1 eq. 26.
  double beta() const {
    return -(inertia(m2, l2) + inertia(m3, l3) + j4 + j6 + j7 + m3 * l2 * l2 + m3 * m3 * l2 * l2 / m2) / j5;
  }
  double gamma() const { return -(inertia(m3, l3) + j6) / j7; }
  static double inertia(double m, double l) { return m * l * l / 12; }

  DesignProblem problem(GoalKind goal) const {
    return design_tests::problem(
        {{"com1", -0.7, 0.7, 0.2},
         {"com2", -0.7, 0.7, 0.2},
         {"com3", -0.7, 0.7, 0.2},
         {"beta", -60, 0, -1},
         {"gamma", -60, 0, -1.5}},
        [arm = *this](const VectorX& x) { return arm.at(x); }, goal);
  }
};

constexpr DiscArm example{0.5, 0.4, 0.3, 5, 2.5, 0.75, 0.03, 0.07, 0.02, 0.06};

/// Two links balanced statically; one disc on the first, whose ratio and inertia are free: decoupled where
/// J2 + J4 + ratio · J5 = 0.
DesignProblem disc_of_free_inertia(double fastest) {
  return problem(
      {{"ratio", fastest, -1, -2}, {"inertia", 0, 0.5, 0.1}},
      [](const VectorX& x) {
        Mechanism m = planar_arm({0.5, 0.4}, {4, 2});
        m.bodies[1].com[0] = -0.25;
        m.bodies[2].com[0] = 0;
        m.discs = {disc("d", 1, 0, 1, x[0], 0, x[1])};
        return m;
      },
      GoalKind::decoupled);
}

}  // namespace

TEST_CASE("discs decouple a planar RRR arm at P1's ratios, whatever its masses") {
  std::mt19937 random(4);
  const auto pick = [&](double a, double b) { return std::uniform_real_distribution<double>(a, b)(random); };
  for (int trial = 0; trial < 3; ++trial) {
    CAPTURE(trial);
    const DiscArm arm{pick(0.3, 0.7), pick(0.3, 0.7),   pick(0.3, 0.7),  pick(4, 6),       pick(2, 3),
                      pick(0.5, 1),   pick(0.01, 0.05), pick(0.05, 0.1), pick(0.01, 0.05), pick(0.05, 0.1)};
    const auto design = arm.problem(GoalKind::decoupled);
    const DesignOutcome outcome = solve_design(design);
    REQUIRE(outcome.status == DesignStatus::balanced);
    CHECK(outcome.method == DesignMethod::geometric);
    CHECK(outcome.x[0] == doctest::Approx(-arm.l1 * (arm.m2 + arm.m3) / arm.m1).epsilon(1e-10));
    CHECK(outcome.x[1] == doctest::Approx(-arm.l2 * arm.m3 / arm.m2).epsilon(1e-10));
    CHECK(std::abs(outcome.x[2]) < 1e-11);
    CHECK(outcome.x[3] == doctest::Approx(arm.beta()).epsilon(1e-10));
    CHECK(outcome.x[4] == doctest::Approx(arm.gamma()).epsilon(1e-10));
    CHECK(judged(design, outcome.x) < condition_tolerance);
  }
}

TEST_CASE("conditions derived anew at every geometry lead to the same ratios") {
  auto design = example.problem(GoalKind::decoupled);
  design.is_modular = design.derives_anew = true;  // whatever `derive` says is asked at every geometry
  const DesignOutcome outcome = solve_design(design);
  REQUIRE(outcome.status == DesignStatus::balanced);
  CHECK(outcome.x[3] == doctest::Approx(example.beta()).epsilon(1e-9));
  CHECK(outcome.x[4] == doctest::Approx(example.gamma()).epsilon(1e-9));
}

TEST_CASE("a number that the goal does not ask for keeps its start value to the last bit") {
  // velocity terms of a planar arm vanish with the static conditions; ratios of discs do not matter for them
  const DesignOutcome outcome = solve_design(example.problem(GoalKind::gyroscopic));
  REQUIRE(outcome.status == DesignStatus::balanced);
  CHECK(outcome.x[3] == -1);
  CHECK(outcome.x[4] == -1.5);
  CHECK(outcome.x[2] == 0);  // exactly: nothing hangs on the last digits
  for (const auto& numbers : outcome.condition_variables)
    for (const int i : numbers) CHECK(i < 3);
}

TEST_CASE("lengths too short for a solution end in a compromise that names what stays open") {
  auto design = example.problem(GoalKind::decoupled);
  design.variables[3] = {"beta", -3, 0, -1};  // about −4.4 is needed
  design.search.max_restarts = 3;
  design.search.max_evaluations = 300;
  const DesignOutcome outcome = solve_design(design);
  CHECK(outcome.status == DesignStatus::compromise);
  CHECK_FALSE(outcome.unmet_conditions.empty());
  CHECK(within_bounds(design, outcome.x));
  CHECK(outcome.reason.find("are not met") != std::string::npos);
}

TEST_CASE("the smallest disc that decouples turns as fast as it may") {
  auto design = disc_of_free_inertia(-8);
  design.objective = sum_of(design.model->build_mechanism(VectorX{{-2, 0.1}}), dynamics::ParameterOwner::disc, "J");
  const DesignOutcome outcome = solve_design(design);
  REQUIRE(outcome.status == DesignStatus::balanced);
  // the second link's inertia about its joint, where its CoM lies
  const double needed = 2 * 0.4 * 0.4 / 12;
  CHECK(outcome.x[0] == doctest::Approx(-8).epsilon(1e-6));
  CHECK(outcome.x[1] == doctest::Approx(needed / 8).epsilon(1e-6));
  CHECK(outcome.residuals_after.cwiseAbs().maxCoeff() < 1e-13);
  CHECK(judged(design, outcome.x) < 1e-12);
}
