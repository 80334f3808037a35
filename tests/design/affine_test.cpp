#include "mechanisms.hpp"
#include "objectives.hpp"

#include <doctest/doctest.h>

using namespace design_tests;

namespace {

/// Met where 0.2 m1 + 0.4 m2 = 0.5.
DesignProblem balanced_link(double max_mass = 10) {
  return two_counterweights({"a.mass", 0, max_mass, 0.3}, {"b.mass", 0, max_mass, 0.1});
}

}  // namespace

TEST_CASE("a slider-crank is force balanced by the centres of mass of crank and rod, and by those alone") {
  // rod: -m_slider l / m_rod; crank: -r (m_rod + m_slider) / m_crank
  const auto design = problem(
      {{"crank.com", -0.2, 0.2, 0.05}, {"rod.com", -0.3, 0.3, 0.15}},
      [](const VectorX& x) {
        Mechanism m = slider_crank();
        m.bodies[1].com[0] = x[0];
        m.bodies[2].com[0] = x[1];
        return m;
      },
      GoalKind::force);
  const DesignOutcome outcome = solve_design(design);
  REQUIRE(outcome.status == DesignStatus::balanced);
  CHECK(outcome.method == DesignMethod::affine);
  CHECK(outcome.x[0] == doctest::Approx(-0.075).epsilon(1e-14));
  CHECK(outcome.x[1] == doctest::Approx(-0.15).epsilon(1e-14));
  // two roundings of numbers of the size of the terms
  CHECK(outcome.residuals_after.cwiseAbs().maxCoeff() < 1e-15);
  CHECK(outcome.residuals_before.cwiseAbs().maxCoeff() > 0.01);
  CHECK(judged(design, outcome.x) < 1e-14);
}

TEST_CASE("without an objective the solution nearest to the start values is taken, in widths of the bounds") {
  const DesignOutcome outcome = solve_design(balanced_link());
  REQUIRE(outcome.status == DesignStatus::balanced);
  // the normal of 0.2 m1 + 0.4 m2 = 0.5 through (0.3, 0.1): both bounds are as wide
  const double step = (0.5 - 0.2 * 0.3 - 0.4 * 0.1) / (0.04 + 0.16);
  CHECK(outcome.x[0] == doctest::Approx(0.3 + 0.2 * step).epsilon(1e-13));
  CHECK(outcome.x[1] == doctest::Approx(0.1 + 0.4 * step).epsilon(1e-13));
}

TEST_CASE("where the nearest solution leaves the bounds the nearest one within them is taken") {
  const DesignOutcome outcome = solve_design(balanced_link(0.9));
  REQUIRE(outcome.status == DesignStatus::balanced);
  CHECK(outcome.x[1] == 0.9);  // at its bound, exactly
  CHECK(outcome.x[0] == doctest::Approx((0.5 - 0.4 * 0.9) / 0.2).epsilon(1e-13));
}

TEST_CASE("of two counterweights the one with the longer arm is used where the added mass is to be small") {
  DesignProblem design = balanced_link();
  design.objective = sum_of(design.model->build_mechanism(VectorX::Zero(2)), dynamics::ParameterOwner::attachment, "m");
  const DesignOutcome outcome = solve_design(design);
  REQUIRE(outcome.status == DesignStatus::balanced);
  CHECK(outcome.x[0] == 0);
  CHECK(outcome.x[1] == doctest::Approx(1.25).epsilon(1e-13));
  CHECK(outcome.objective == doctest::Approx(1.25).epsilon(1e-13));
  CHECK(outcome.start_objective == doctest::Approx(0.4).epsilon(1e-13));
  CHECK(outcome.optimality == Optimality::proved_global);
  // the bound proves at least six digits
  CHECK(outcome.lower_bound <= outcome.objective);
  CHECK(outcome.lower_bound == doctest::Approx(1.25).epsilon(1e-6));
}

TEST_CASE("the least sum of squares among exact solutions is found and proved") {
  DesignProblem design = balanced_link();
  design.objective =
      sum_of(design.model->build_mechanism(VectorX::Zero(2)), dynamics::ParameterOwner::attachment, "m", true);
  const DesignOutcome outcome = solve_design(design);
  REQUIRE(outcome.status == DesignStatus::balanced);
  // the point of the line that is nearest to the origin
  CHECK(outcome.x[0] == doctest::Approx(0.5 * 0.2 / 0.2).epsilon(1e-9));
  CHECK(outcome.x[1] == doctest::Approx(0.5 * 0.4 / 0.2).epsilon(1e-9));
  CHECK(outcome.optimality == Optimality::proved_global);
  CHECK(outcome.lower_bound <= outcome.objective);
  CHECK(outcome.lower_bound == doctest::Approx(1.25).epsilon(1e-6));
}

TEST_CASE("a peak, which has kinks, is minimised and the minimum proved") {
  // max(m1, 3 m2) is least where both are equal: 0.2 t + 0.4 t / 3 = 0.5
  DesignProblem design = balanced_link();
  Objective peak;
  peak.name = "peak";
  peak.is_convex = true;
  const auto parameters = dynamics::list_parameters(design.model->build_mechanism(VectorX::Zero(2)));
  Eigen::Index first = 0, second = 0;
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    if (parameters[p].name == "a.m") first = static_cast<Eigen::Index>(p);
    if (parameters[p].name == "b.m") second = static_cast<Eigen::Index>(p);
  }
  peak.function = of_parameters([first, second](const VectorX& p, VectorX* gradient) {
    const bool second_rules = 3 * p[second] > p[first];
    if (gradient != nullptr)
      *gradient = VectorX::Unit(p.size(), second_rules ? second : first) * (second_rules ? 3 : 1);
    return std::max(p[first], 3 * p[second]);
  });
  design.objective = peak;
  const DesignOutcome outcome = solve_design(design);
  REQUIRE(outcome.status == DesignStatus::balanced);
  CHECK(outcome.objective == doctest::Approx(1.5).epsilon(1e-6));
  CHECK(outcome.optimality == Optimality::proved_global);
  CHECK(outcome.lower_bound <= 1.5 * (1 + 1e-12));
  CHECK(outcome.lower_bound == doctest::Approx(1.5).epsilon(1e-6));
}

TEST_CASE("the stiffness of a spring of zero free length carries a link in every position") {
  // k h a = m g l: spring from (0, h) to a on the link
  const auto design = problem(
      {{"k", 0, 5000, 100}},
      [](const VectorX& x) {
        Mechanism m = planar_arm({0.5}, {2});
        Spring spring{"s", 0, 1, {0, 0.3, 0}, {0.2, 0, 0}, x[0], 0};
        m.springs = {spring};
        return m;
      },
      GoalKind::statics);
  const DesignOutcome outcome = solve_design(design);
  REQUIRE(outcome.status == DesignStatus::balanced);
  CHECK(outcome.method == DesignMethod::affine);
  CHECK(outcome.x[0] == doctest::Approx(2 * 9.81 * 0.25 / (0.3 * 0.2)).epsilon(1e-12));
}

TEST_CASE("where a spring of zero free length is hung up is a matter of masses, not of geometry") {
  const auto design = problem(
      {{"s.x", -0.2, 0.2, 0.05}, {"s.y", 0, 1, 0.1}},
      [](const VectorX& x) {
        Mechanism m = planar_arm({0.5}, {2});
        Spring spring{"s", 0, 1, {x[0], x[1], 0}, {0.2, 0, 0}, 150, 0};
        m.springs = {spring};
        return m;
      },
      GoalKind::statics);
  CHECK(find_loose_springs(design) == dynamics::FreeSprings{true});
  const DesignOutcome outcome = solve_design(design);
  REQUIRE(outcome.status == DesignStatus::balanced);
  CHECK(outcome.method == DesignMethod::affine);
  CHECK(outcome.x[0] == doctest::Approx(0).epsilon(1e-12));
  CHECK(outcome.x[1] == doctest::Approx(2 * 9.81 * 0.25 / (150 * 0.2)).epsilon(1e-12));
  CHECK(judged(design, outcome.x) < 1e-12);  // as ordinary springs too
}

TEST_CASE("the same problem has the same solution to the last bit") {
  DesignProblem design = balanced_link();
  design.objective =
      sum_of(design.model->build_mechanism(VectorX::Zero(2)), dynamics::ParameterOwner::attachment, "m", true);
  const DesignOutcome first = solve_design(design), second = solve_design(design);
  CHECK(first.x == second.x);
  CHECK(first.lower_bound == second.lower_bound);
}
