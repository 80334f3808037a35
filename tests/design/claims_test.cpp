#include "balance/synthesis/design/multistart.hpp"
#include "mechanisms.hpp"
#include "objectives.hpp"

#include <doctest/doctest.h>

#include <cmath>

namespace claims_test {

using namespace design_tests;

namespace {

Objective by_variables(std::function<double(const VectorX&)> f, const std::string& failure_reason = "") {
  Objective figure;
  figure.name = "figure";
  figure.function = of_variables(std::move(f), failure_reason);
  return figure;
}

}  // namespace

TEST_CASE("a search comes back from a bound at which the figure is smaller than near the start (B4)") {
  // falls from 0 towards both bounds of the curve, deepest inside at 0.62, with a ridge before it
  const auto valley = [](double x) { return x < 0.3 ? 2 + 3 * x : 1 + 8 * (x - 0.62) * (x - 0.62); };
  design::SearchBudget budget(10);
  design::MultistartSettings task;
  task.objective = [&](const VectorX& u) { return valley(u[0]); };
  task.starts = {VectorX::Zero(1), VectorX::Constant(1, 1.0), VectorX::Constant(1, -1.0)};
  task.max_local_searches = 0;  // the steps at the end alone
  task.starts = {VectorX::Constant(1, 1.0)};
  CHECK(design::search_multistart(task, budget).u[0] == doctest::Approx(0.62).epsilon(1e-4));
}

TEST_CASE("a search goes round points without a value and never asks for one that is not finite (B5)") {
  for (const std::string method : {"cobyla", "bobyqa", "sbplx"}) {
    CAPTURE(method);
    design::SearchBudget budget(10);
    design::MultistartSettings task;
    bool finite = true;
    task.objective = [&](const VectorX& u) {
      finite = finite && u.allFinite();
      return u[0] + u[1] < -0.4 ? NAN : (u - Eigen::Vector2d(-0.3, 0.2)).squaredNorm();
    };
    task.starts = design::low_discrepancy_points(6, 2, 1);
    task.method = method;
    const design::MultistartResult found = design::search_multistart(task, budget);
    CHECK(finite);
    CHECK(found.value < 1e-6);
  }
}

TEST_CASE("points without a value anywhere are said to be none (B5)") {
  design::SearchBudget budget(10);
  design::MultistartSettings task;
  task.objective = [](const VectorX&) { return NAN; };
  task.starts = design::low_discrepancy_points(3, 2, 1);
  CHECK_FALSE(std::isfinite(design::search_multistart(task, budget).value));
}

TEST_CASE("an objective that has no value at any exact design is no design, and says why (B7)") {
  auto design = two_counterweights();
  design.objective = by_variables([](const VectorX&) { return NAN; }, "it stands still");
  const DesignOutcome outcome = solve_design(design);
  CHECK(outcome.status == DesignStatus::unsolved);
  CHECK(outcome.reason ==
        "figure cannot be computed for any numbers that were found to meet the conditions: it stands still");
}

TEST_CASE("exact designs at which the objective has no value are passed over (B7)") {
  auto design = two_counterweights();
  design.objective = by_variables([](const VectorX& x) { return x[1] > 0.7 ? NAN : x.squaredNorm(); });
  const DesignOutcome outcome = solve_design(design);
  REQUIRE(outcome.status == DesignStatus::balanced);
  CHECK(outcome.optimality == Optimality::local_optimum);
  // the least is at the edge of where there is a value: b = 0.7, a = 1.1
  CHECK(outcome.x[1] <= 0.7);
  CHECK(outcome.objective == doctest::Approx(1.7).epsilon(1e-3));
}

TEST_CASE("a line of solutions is one freedom, a bound or an objective takes it (B11)") {
  auto design = two_counterweights();
  DesignOutcome outcome = solve_design(design);
  CHECK(outcome.optimality == Optimality::not_optimised);
  CHECK(outcome.solution_set.optimal_dimension == 1);
  CHECK(outcome.solution_set.free_variables == std::vector<int>{0, 1});
  design.objective = sum_of(design.model->build_mechanism(VectorX{{0, 0}}), dynamics::ParameterOwner::attachment, "m");
  outcome = solve_design(design);
  CHECK(outcome.optimality == Optimality::proved_global);
  CHECK(outcome.gap() <= 1e-6);
  CHECK(outcome.solution_set.dimension == 1);
  CHECK(outcome.solution_set.optimal_dimension == 0);
  // 0.2 a + 0.4 b = 0.5 at a = 0 and b at its most: nothing else is allowed
  design.objective.reset();
  design.variables[1] = {"b", 0, 1.25, 0};
  design.variables[0] = {"a", 0, 1e-3, 0};
  design.model = model_of([](const VectorX& x) {
    Mechanism m = planar_arm({0.5}, {2});
    m.attachments = {counterweight("a", 1, 0.2, 0, x[0]), counterweight("b", 1, -0.4, 0, x[1])};
    return m;
  });
  outcome = solve_design(design);
  REQUIRE(outcome.status == DesignStatus::balanced);
  CHECK(outcome.solution_set.optimal_dimension == 0);
}

TEST_CASE("numbers that occur nowhere stay free and are named (B11)") {
  auto design = two_counterweights();
  design.variables.push_back({"idle", -1, 1, 0.3});
  const DesignOutcome outcome = solve_design(design);
  CHECK(outcome.solution_set.optimal_dimension == 2);
  CHECK(outcome.solution_set.free_variables == std::vector<int>{0, 1, 2});
  CHECK(outcome.x[2] == 0.3);
}

TEST_CASE("without a goal the objective alone is made small, with a bound where it is convex (B12)") {
  auto design = two_counterweights();
  design.goals.clear();
  CHECK_THROWS_WITH_AS(solve_design(design), "a design needs a goal, something to minimize or limits",
                       std::invalid_argument);
  design.objective = by_variables([](const VectorX& x) { return (x - Eigen::Vector2d(3, 12)).squaredNorm(); });
  DesignOutcome outcome = solve_design(design);
  CHECK(outcome.status == DesignStatus::no_goal);
  CHECK(outcome.optimality == Optimality::local_optimum);
  CHECK(outcome.x[0] == doctest::Approx(3).epsilon(1e-4));
  CHECK(outcome.x[1] == doctest::Approx(10).epsilon(1e-6));
  design.objective = sum_of(design.model->build_mechanism(VectorX{{0, 0}}), dynamics::ParameterOwner::attachment, "m");
  outcome = solve_design(design);
  CHECK(outcome.optimality == Optimality::proved_global);
  CHECK(outcome.x.norm() < 1e-6);
}

TEST_CASE("a square that cannot be as small as a fixed mass asks for is a proof (B9)") {
  // mx = m c, J = J0 + m c^2; decoupling asks for J, which c > 0.2 makes too large for the disc's ratio
  const auto arm = [](double furthest) {
    return problem(
        {{"com", 0.2, furthest, 0.25}, {"weight", 0, 5, 1}},
        [](const VectorX& x) {
          Mechanism m = planar_arm({0.5}, {2});
          m.bodies[1].com[0] = x[0];
          m.attachments = {counterweight("w", 1, -0.2, 0, x[1])};
          return m;
        },
        GoalKind::statics);
  };
  // 2 c = 0.2 w: linear, and possible only where w may be 10 c
  CHECK(solve_design(arm(0.4)).status == DesignStatus::balanced);
  auto none = arm(0.4);
  none.variables[1].upper = 1.9;
  const DesignOutcome outcome = solve_design(none);
  CHECK(outcome.status == DesignStatus::infeasible);
  CHECK(outcome.is_proved_infeasible);
}

TEST_CASE("a search that runs out of time says so (B6)") {
  auto design = two_counterweights();
  design.objective = by_variables([](const VectorX& x) {
    volatile double sum = 0;
    for (int k = 0; k < 200000; ++k) sum = sum + std::sin(k * x[0]);
    return x.squaredNorm() + 0 * sum;
  });
  design.search.max_time = 0.05;
  const DesignOutcome outcome = solve_design(design);
  CHECK(outcome.status == DesignStatus::balanced);
  CHECK(outcome.optimality == Optimality::budget_exhausted);
}

}  // namespace claims_test
