// Values between samples, crossings and extremes of sampled quantities.

#include "balance/interface/comparison/sampled_curve.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <functional>
#include <numbers>

using namespace balance;
using namespace balance::comparison;

namespace {

using Gap = SampledCurve::Gap;

SampledCurve curve_of(const VectorX& time, const std::function<double(double)>& f) {
  Samples samples(time.size(), 1);
  for (Eigen::Index k = 0; k < time.size(); ++k) samples(k, 0) = f(time[k]);
  return {time, samples};
}

/// 1 + t before 0.55 and −1 − t after it, with or without both sides of the jump.
SampledCurve jumping_curve(bool with_sides) {
  std::vector<std::pair<double, double>> rows;
  for (int k = 0; k <= 10; ++k) {
    const double t = 0.1 * k;
    if (with_sides && k == 6) rows.insert(rows.end(), {{0.55, 1.55}, {0.55, -1.55}});
    rows.emplace_back(t, t < 0.55 ? 1 + t : -1 - t);
  }
  VectorX time(static_cast<Eigen::Index>(rows.size()));
  Samples samples(time.size(), 1);
  for (Eigen::Index k = 0; k < time.size(); ++k)
    time[k] = rows[static_cast<std::size_t>(k)].first, samples(k, 0) = rows[static_cast<std::size_t>(k)].second;
  return {time, samples};
}

}  // namespace

TEST_CASE("polynomials of third degree are met exactly, with their crossings and extremes") {
  // roots 0.3, 0.75 and 1.6; extremes where 3 t² − 5.3 t + 1.905 = 0
  const auto cubic = [](double t) { return (t - 0.3) * (t - 0.75) * (t - 1.6); };
  const SampledCurve curve = curve_of(VectorX::LinSpaced(8, 0, 2), cubic);
  for (const double t : {0., 0.05, 0.7, 1.99, 2.})
    CHECK(curve.evaluate(t).first == doctest::Approx(cubic(t)).epsilon(1e-12).scale(1));
  const std::vector<double> roots = curve.find_crossings(0);
  REQUIRE(roots.size() == 3);
  CHECK(roots[0] == doctest::Approx(0.3).epsilon(1e-12));
  CHECK(roots[1] == doctest::Approx(0.75).epsilon(1e-12));
  CHECK(roots[2] == doctest::Approx(1.6).epsilon(1e-12));
  // the largest values are at the ends of the time; the extremes between them are not
  CHECK(curve.find_extremum(SampledCurve::Extremum::maximum) == 2);
  CHECK(curve.find_extremum(SampledCurve::Extremum::minimum) == 0);
  const SampledCurve part = curve_of(VectorX::LinSpaced(8, 0.2, 1.6), cubic);
  const double root = std::sqrt(5.3 * 5.3 - 12 * 1.905);
  CHECK(part.find_extremum(SampledCurve::Extremum::maximum) == doctest::Approx((5.3 - root) / 6).epsilon(1e-10));
  CHECK(part.find_extremum(SampledCurve::Extremum::minimum) == doctest::Approx((5.3 + root) / 6).epsilon(1e-10));
  CHECK(part.find_extremum(SampledCurve::Extremum::peak) == doctest::Approx((5.3 + root) / 6).epsilon(1e-10));
}

TEST_CASE("two crossings within one step are both found") {
  const SampledCurve curve = curve_of(VectorX::LinSpaced(5, 0, 4), [](double t) { return (t - 1.4) * (t - 1.6); });
  const std::vector<double> roots = curve.find_crossings(0);
  REQUIRE(roots.size() == 2);
  CHECK(roots[0] == doctest::Approx(1.4).epsilon(1e-12));
  CHECK(roots[1] == doctest::Approx(1.6).epsilon(1e-12));
}

TEST_CASE("a level is touched at an extremum and at an end, and met once where the curve stays on it") {
  const SampledCurve hill = curve_of(VectorX::LinSpaced(9, 0, 1), [](double t) { return 4 * t * (1 - t); });
  CHECK(hill.find_crossings(1).size() == 1);
  CHECK(hill.find_crossings(1)[0] == doctest::Approx(0.5).epsilon(1e-9));  // a double root
  CHECK(hill.find_crossings(0) == std::vector<double>{0, 1});
  CHECK(hill.find_crossings(1.001).empty());
  const auto dwell = [](double t) { return t < 0.5 ? std::pow(1 - 2 * t, 4) : 0; };
  const SampledCurve rest = curve_of(VectorX::LinSpaced(41, 0, 1), dwell);
  CHECK(rest.find_crossings(0).size() == 1);
  // round-off on the level is no crossing
  const SampledCurve perturbed = curve_of(
      VectorX::LinSpaced(41, 0, 1), [&](double t) { return 1 - dwell(t) + (t > 0.5 ? 1e-16 * std::sin(1e6 * t) : 0); });
  CHECK(perturbed.find_crossings(1).size() == 1);
}

TEST_CASE("the end of a cycloid is reached although round-off keeps it below its last value") {
  const auto cycloid = [](double t) {
    return std::numbers::pi / 3 * (t - std::sin(2 * std::numbers::pi * t) / (2 * std::numbers::pi));
  };
  for (const Eigen::Index n : {11, 101, 10001}) {
    const SampledCurve curve = curve_of(VectorX::LinSpaced(n, 0, 1), cycloid);
    const std::vector<double> ends = curve.find_crossings(std::numbers::pi / 3 * (1 + 1e-15));
    CAPTURE(n);
    CAPTURE(ends.front());
    REQUIRE(ends.size() == 1);
    CHECK(ends[0] == doctest::Approx(1).epsilon(2e-3));  // 1e-9 of the way remains at 1 − 1.2e-3
  }
}

TEST_CASE("a value at a jump is that of the chosen side") {
  for (const bool with_sides : {true, false}) {
    const SampledCurve curve = jumping_curve(with_sides);
    CAPTURE(with_sides);
    CHECK(curve.evaluate(0.55, JumpSide::before).first == doctest::Approx(1.55).epsilon(1e-13));
    CHECK(curve.evaluate(0.55, JumpSide::after).first == doctest::Approx(-1.55).epsilon(1e-13));
    CHECK(curve.evaluate(0.3, JumpSide::after).first == doctest::Approx(1.3).epsilon(1e-13));
    CHECK(curve.evaluate(0.58, JumpSide::any).second == (with_sides ? Gap::none : Gap::jump));
    CHECK(curve.find_crossings(0).empty());  // a jump is no crossing
    CHECK(curve.evaluate(1.1).second == Gap::outside);
  }
  CHECK(jumping_curve(true).evaluate(0.55).first == -1.55);  // as a sample: after it
  CHECK(jumping_curve(false).evaluate(0.55).second == Gap::jump);
  CHECK(jumping_curve(true).find_extremum(SampledCurve::Extremum::maximum) == 0.55);
}

TEST_CASE("of a vector the magnitude counts") {
  const VectorX time = VectorX::LinSpaced(41, 0, 2);
  Samples samples(41, 2);
  for (Eigen::Index k = 0; k < 41; ++k) samples.row(k) << time[k] - 1, 0.5;
  const SampledCurve curve(time, samples);
  CHECK(curve.evaluate(1.33).first == doctest::Approx(std::hypot(0.33, 0.5)).epsilon(1e-13));
  const double level = std::hypot(0.4, 0.5);
  const std::vector<double> crossings = curve.find_crossings(level);
  REQUIRE(crossings.size() == 2);
  CHECK(crossings[0] == doctest::Approx(0.6).epsilon(1e-12));
  CHECK(crossings[1] == doctest::Approx(1.4).epsilon(1e-12));
}
