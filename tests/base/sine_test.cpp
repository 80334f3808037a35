#include "ulps.hpp"

#include "balance/foundation/base/pack.hpp"

#include <doctest/doctest.h>

#include <cfloat>
#include <functional>
#include <limits>
#include <random>

using namespace balance;

namespace {

void check_error(long count, const std::function<double()>& argument) {
  double worst = 0, at = 0;
  for (long k = 0; k < count; ++k) {
    const double x = argument();
    const SineCosine<double> found = sine_cosine(x);
    const double error = std::max(ulps(found.sine, std::sin(static_cast<long double>(x))),
                                  ulps(found.cosine, std::cos(static_cast<long double>(x))));
    if (error > worst) worst = error, at = x;
  }
  CAPTURE(at);
  CHECK(worst <= 0.8);
}

}  // namespace

TEST_CASE("sine and cosine are right to 0.8 units in the last place, of large arguments and near their zeros too") {
  if (LDBL_MANT_DIG < 64) return;  // nothing to measure with
  std::mt19937_64 random(1);
  for (const double range : {1.0, 6.3, 1e3, 1e5, 1e6, 1e15, 1e300})
    check_error(20000, [&] { return std::uniform_real_distribution<double>(-range, range)(random); });
  check_error(20000, [&] {
    return std::ldexp(1 + 0x1p-52 * static_cast<double>(random() >> 12), static_cast<int>(random() % 2000) - 1000);
  });
  // the doubles nearest to multiples of π/2
  for (const long multiples : {63662L, 1L << 52})
    check_error(20000, [&] {
      return static_cast<double>(1.57079632679489661923L * static_cast<long double>(random() % multiples));
    });
  // of all doubles the nearest to one (J.-M. Muller et al., Handbook of Floating-Point Arithmetic, 2018, table 11.1)
  CHECK(sine_cosine(6381956970095103 * 0x1p797).cosine == -4.6871659242546277e-19);
}

TEST_CASE("sine and cosine keep the sign of zero and make no number of what is none") {
  CHECK(std::signbit(sine_cosine(-0.0).sine));
  CHECK(sine_cosine(0.0).cosine == 1);
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double x : {infinity, -infinity, std::numeric_limits<double>::quiet_NaN()}) {
    CHECK(std::isnan(sine_cosine(x).sine));
    CHECK(std::isnan(sine_cosine(x).cosine));
  }
}

TEST_CASE("a lane's sine is the number's, whatever is in the other lanes") {
  std::mt19937_64 random(2);
  const double mixed[8] = {0.3, 1e5, 2e7, -1e300, -0.0, 1e-310, 99999.9, -7};
  for (int round = 0; round < 200; ++round) {
    double x[8];
    for (double& one : x) one = mixed[random() % 8] * (1 + 0x1p-20 * static_cast<double>(random() % 1000));
    const auto found = sine_cosine(Pack<8>::load(x));
    const auto halved = sine_cosine(Pack<2>::load(x + 4));
    for (int l = 0; l < 8; ++l) {
      CHECK(found.sine[l] == sine_cosine(x[l]).sine);
      CHECK(found.cosine[l] == sine_cosine(x[l]).cosine);
    }
    CHECK(halved.sine[1] == found.sine[5]);
  }
}
