#include "balance/foundation/numerics/bracketed_root.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

using namespace balance;
using namespace balance::numerics;

TEST_CASE("a bracketed root is found to its last digits, whatever the function's shape") {
  int count = 0;
  const auto root_of = [&](auto f, double a, double b) {
    count = 0;
    return find_bracketed_root([&](double x) { return ++count, f(x); }, a, b, f(a), f(b), 1e-12);
  };
  CHECK(root_of([](double x) { return x * x - 2; }, 0, 2) == doctest::Approx(std::sqrt(2)).epsilon(1e-12));
  CHECK(count < 15);  // bisection would take 40
  CHECK(root_of([](double x) { return std::cos(x); }, 3, 0) == doctest::Approx(std::numbers::pi / 2).epsilon(1e-12));
  CHECK(root_of([](double x) { return 3 - 1e6 * x; }, 0, 1) == doctest::Approx(3e-6).epsilon(1e-12));
  // flat on one side, and a step
  CHECK(root_of([](double x) { return std::exp(20 * x) - 2; }, -5, 5) ==
        doctest::Approx(std::log(2) / 20).epsilon(1e-12));
  CHECK(root_of([](double x) { return x < 0.3 ? -1. : 1.; }, 0, 1) == doctest::Approx(0.3).epsilon(1e-12));
  // a triple root: the function is round-off around it
  CHECK(root_of([](double x) { return std::pow(x - 1, 3); }, 0, 3) == doctest::Approx(1).epsilon(1e-9));
  CHECK(root_of([](double x) { return x; }, 0, 1) == 0);
}
