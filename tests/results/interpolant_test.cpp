#include "balance/interface/comparison/sample_difference.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <functional>

using namespace balance;
using namespace balance::comparison;

namespace {

Samples sampled(const VectorX& time, const std::function<double(double)>& f) {
  Samples samples(time.size(), 1);
  for (Eigen::Index k = 0; k < time.size(); ++k) samples(k, 0) = f(time[k]);
  return samples;
}

}  // namespace

TEST_CASE("polynomials of third degree are met exactly, to the last step") {
  const auto cubic = [](double t) { return 1 - 2 * t + 3 * t * t - 4 * t * t * t; };
  const VectorX time = VectorX::LinSpaced(9, 0, 2);
  const Samples samples = sampled(time, cubic);
  const SampleInterpolant between(time, samples, 0, 1);
  for (const double t : {0., 0.01, 0.6, 1.125, 1.99, 2.}) {
    REQUIRE(between.evaluate(t));
    CHECK((*between.evaluate(t))[0] == doctest::Approx(cubic(t)).epsilon(1e-13));  // round-off of numbers up to 25
  }
}

TEST_CASE("the error falls with the fourth power of the step") {
  const auto worst = [](Eigen::Index n) {
    const VectorX time = VectorX::LinSpaced(n, 0, 1);
    const Samples samples = sampled(time, [](double t) { return std::sin(6 * t); });
    const SampleInterpolant between(time, samples, 0, 1);
    double most = 0;
    for (double t = 0.3; t < 0.7; t += 0.001)
      most = std::max(most, std::abs((*between.evaluate(t))[0] - std::sin(6 * t)));
    return most;
  };
  CHECK(worst(41) / worst(81) == doctest::Approx(16).epsilon(0.1));
}

TEST_CASE("nothing is made up within a step that jumps, and nothing leaks across it") {
  const auto square = [](double t) { return t < 0.5 ? 1 + t : -1 - t; };
  const VectorX time = VectorX::LinSpaced(11, 0, 1);
  const Samples samples = sampled(time, square);
  const SampleInterpolant between(time, samples, 0, 1);
  CHECK_FALSE(between.evaluate(0.45));
  CHECK((*between.evaluate(0.4))[0] == doctest::Approx(1.4).epsilon(1e-14));
  CHECK((*between.evaluate(0.5))[0] == doctest::Approx(-1.5).epsilon(1e-14));
  for (const double t : {0.33, 0.39, 0.51, 0.55})
    CHECK((*between.evaluate(t))[0] == doctest::Approx(square(t)).epsilon(1e-12));
}

TEST_CASE("a flat step beside a steep one is no jump") {
  const auto hill = [](double t) { return -(t - 0.15) * (t - 0.15); };  // its top in the middle of the second step
  const VectorX time = VectorX::LinSpaced(11, 0, 1);
  const Samples samples = sampled(time, hill);
  const SampleInterpolant between(time, samples, 0, 1);
  for (double t = 0; t <= 1; t += 0.05) CHECK(between.evaluate(t));
}

TEST_CASE("round-off on constants is no jump") {
  const VectorX time = VectorX::LinSpaced(11, 0, 1);
  Samples samples = sampled(time, [](double) { return 549.25; });
  samples(5, 0) += 1e-12;
  CHECK(SampleInterpolant(time, samples, 0, 1).evaluate(0.45));
}

TEST_CASE("there is nothing outside the samples; a sample is itself within round-off") {
  const VectorX time = VectorX::LinSpaced(5, 0, 1);
  const Samples samples = sampled(time, [](double t) { return t; });
  const SampleInterpolant between(time, samples, 0, 1);
  CHECK_FALSE(between.evaluate(-0.1));
  CHECK_FALSE(between.evaluate(1.1));
  CHECK((*between.evaluate(1 + 1e-12))[0] == 1);
  CHECK((*between.evaluate(0.25 - 1e-12))[0] == 0.25);
}

TEST_CASE("a vector is interpolated in all of its columns and no others") {
  const VectorX time = VectorX::LinSpaced(5, 0, 1);
  Samples samples(5, 4);
  for (Eigen::Index k = 0; k < 5; ++k) samples.row(k) << NAN, time[k], 2 * time[k], NAN;
  const SampleInterpolant between(time, samples, 1, 2);
  CHECK(((*between.evaluate(0.3)) - Vector2(0.3, 0.6)).norm() < 1e-15);
}
