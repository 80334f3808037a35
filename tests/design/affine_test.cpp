#include "mechanisms.hpp"

#include <doctest/doctest.h>

using namespace design_tests;

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
  const DesignOutcome outcome = solve(design);
  REQUIRE(outcome.status == DesignStatus::balanced);
  CHECK(outcome.method == DesignMethod::affine);
  CHECK(outcome.x[0] == doctest::Approx(-0.075).epsilon(1e-14));
  CHECK(outcome.x[1] == doctest::Approx(-0.15).epsilon(1e-14));
  // two roundings of numbers of the size of the terms
  CHECK(outcome.after.cwiseAbs().maxCoeff() < 1e-15);
  CHECK(outcome.before.cwiseAbs().maxCoeff() > 0.01);
  CHECK(judged(design, outcome.x) < 1e-14);
}
