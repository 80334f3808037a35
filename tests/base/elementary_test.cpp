#include "ulps.hpp"

#include "balance/foundation/base/elementary.hpp"

#include <doctest/doctest.h>

#include <cfloat>
#include <cmath>
#include <limits>
#include <random>
#include <string>

using namespace balance;

namespace {

struct Function {
  std::string name;
  double (*found)(double);
  long double (*exact)(long double);
  double lower, upper, error;
};

// The last column: what is rounded once is right to half a unit.
const Function functions[] = {
    {"tan", elementary::tan, std::tan, -100, 100, 2},         {"asin", elementary::asin, std::asin, -1, 1, 2},
    {"acos", elementary::acos, std::acos, -1, 1, 2},          {"atan", elementary::atan, std::atan, -20, 20, 1.5},
    {"sinh", elementary::sinh, std::sinh, -20, 20, 0.501},    {"cosh", elementary::cosh, std::cosh, -20, 20, 0.501},
    {"tanh", elementary::tanh, std::tanh, -5, 5, 0.501},      {"asinh", elementary::asinh, std::asinh, -50, 50, 0.501},
    {"acosh", elementary::acosh, std::acosh, 1, 50, 0.501},   {"atanh", elementary::atanh, std::atanh, -1, 1, 0.501},
    {"exp", elementary::exp, std::exp, -700, 700, 0.501},     {"log", elementary::log, std::log, 0, 1e6, 0.501},
    {"log10", elementary::log10, std::log10, 0, 1e6, 0.501},  {"log2", elementary::log2, std::log2, 0, 1e6, 0.501},
    {"log1p", elementary::log1p, std::log1p, -1, 100, 0.501},
};

}  // namespace

TEST_CASE("elementary functions are right to the last place or two") {
  if (LDBL_MANT_DIG < 64) return;  // nothing to measure with
  std::mt19937_64 random(1);
  for (const Function& f : functions) {
    CAPTURE(f.name);
    double worst = 0, at = 0;
    for (int k = 0; k < 5000; ++k) {
      const double x = std::uniform_real_distribution<double>(f.lower, f.upper)(random);
      const double error = ulps(f.found(x), f.exact(static_cast<long double>(x)));
      if (error > worst) worst = error, at = x;
    }
    CAPTURE(at);
    CHECK(worst <= f.error);
    CHECK(worst > 0);
  }
}

TEST_CASE("the angle of a direction, of any size and in every quadrant") {
  if (LDBL_MANT_DIG < 64) return;
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> any(-1, 1);
  for (const double size : {1.0, 1e-160, 1e-305, 1e160, 1e308}) {
    CAPTURE(size);
    double worst = 0;
    for (int k = 0; k < 20000; ++k) {
      const double flat = std::ldexp(1.0, -static_cast<int>(random() % 40));
      double y = size * any(random), x = size * any(random);
      (k % 2 ? y : x) *= flat;
      if (std::fabs(y) < 1e-300 || std::fabs(x) < 1e-300) continue;  // digits are missing from the arguments
      worst = std::max(
          worst, ulps(elementary::atan2(y, x), std::atan2(static_cast<long double>(y), static_cast<long double>(x))));
    }
    CHECK(worst <= 1.5);
  }
  // Signed zeros, infinities and what is no number: as IEEE 754 has them.
  constexpr double inf = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
  for (const double y : {0.0, -0.0, 1.0, -1.0, inf, -inf, nan})
    for (const double x : {0.0, -0.0, 1.0, -1.0, inf, -inf, nan}) {
      CAPTURE(y);
      CAPTURE(x);
      const double found = elementary::atan2(y, x), wanted = std::atan2(y, x);
      CHECK(std::signbit(found) == std::signbit(wanted));
      CHECK((found == wanted || (std::isnan(found) && std::isnan(wanted))));
    }
}

TEST_CASE("powers are products where they can be") {
  CHECK(elementary::pow(-3, 3) == -27);
  CHECK(elementary::pow(2, -2) == 0.25);
  CHECK(elementary::pow(0, 0) == 1);
  CHECK(elementary::pow(10, 15) == 1e15);
  CHECK(elementary::pow(10, 22) == 1e22);
  CHECK(elementary::pow(2, 0.5) == std::sqrt(2.0));
  CHECK(std::isnan(elementary::pow(-2, 0.5)));
  CHECK(elementary::pow(1e200, 2) == std::numeric_limits<double>::infinity());
  CHECK(elementary::pow(1e200, -2) == 0);
  CHECK(std::isnan(elementary::log(-1)));
  CHECK(std::isnan(elementary::acos(1.5)));
}
