#include "balance/synthesis/design/start_agreement.hpp"
#include "balance/synthesis/design/incumbent.hpp"
#include "mechanisms.hpp"
#include "objectives.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace start_agreement_test {

using namespace design_tests;

TEST_CASE("design: an incumbent is exact before it is light, and never gets worse") {
  design::Incumbent incumbent;
  const VectorX a = VectorX::Constant(1, 0.1), b = VectorX::Constant(1, 0.2);
  incumbent.offer(a, false, 1);
  incumbent.offer(b, true, 5);
  CHECK(incumbent.is_exact());
  CHECK(incumbent.value() == 5);
  incumbent.offer(a, false, 1);
  incumbent.offer(a, true, 6);
  incumbent.offer(a, true, std::numeric_limits<double>::quiet_NaN());
  CHECK(incumbent.u() == b);
  incumbent.offer(a, true, 4);
  CHECK(incumbent.value() == 4);
}

TEST_CASE("design: starts agree up to 1e-6 of the best value, also where that is negative or zero") {
  const double none = std::numeric_limits<double>::quiet_NaN();
  for (const double best : {2.0, -2.0}) {
    const StartAgreement agreement =
        compare_starts({best, best + 1e-6, best + 1e-5, best + 0.5, none}, best);  // 1e-6 is half of the tolerance
    CHECK(agreement.starts == 5);
    CHECK(agreement.agreeing == 2);
    CHECK(agreement.failed == 1);
    CHECK(agreement.nearest_other == doctest::Approx(5e-6));
    CHECK(agreement.farthest_other == doctest::Approx(0.25));
    CHECK(!agreement.is_reached());
  }
  CHECK(compare_starts({0, 5e-13, 0, 1}, 0).agreeing == 3);
}

/// Two counterweights with a figure of several minima along the line of exact designs.
DesignProblem wavy_problem(int max_starts) {
  DesignProblem wavy = two_counterweights({"a", 0, 2.5, 2.4});
  Objective figure;
  figure.name = "figure";
  figure.function = of_variables([](const VectorX& x) { return 3 + std::cos(9 * x[0]) + 0.2 * x[0]; });
  wavy.objective = figure;
  wavy.search.max_restarts = max_starts;
  return wavy;
}

TEST_CASE("design: more starts never give a worse design, and a search ends when three agree") {
  double before = std::numeric_limits<double>::infinity();
  for (const int starts : {1, 2, 4, 8, 16, 32}) {
    const DesignOutcome outcome = solve_design(wavy_problem(starts));
    REQUIRE(outcome.status == DesignStatus::balanced);
    CHECK(outcome.residuals_after.cwiseAbs().maxCoeff() < condition_tolerance);
    CHECK(outcome.objective <= before);
    before = outcome.objective;
    const StartAgreement agreement = compare_starts(outcome.effort.ends, outcome.objective);
    CHECK(agreement.starts <= starts);
    CHECK((agreement.is_reached() || agreement.starts == starts));
  }
  // the least of the minima of 3 + cos 9 a + 0.2 a, next to a = pi / 9
  const double a = std::numbers::pi / 9 - 0.2 / 81;
  CHECK(before == doctest::Approx(3 + std::cos(9 * a) + 0.2 * a).epsilon(1e-6));
}

}  // namespace start_agreement_test
