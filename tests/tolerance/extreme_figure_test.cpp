// How far the largest of several linear figures is off, against Clark's closed form and against draws of its own.

#include "balance/synthesis/tolerance/extreme_figure.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

using namespace balance;
using namespace balance::tolerance;

namespace {

constexpr double hundredth = 0.02;  // 16384 draws leave a standard error of 0.6 %; three of them

VectorX vector(std::initializer_list<double> entries) {
  VectorX out(static_cast<Eigen::Index>(entries.size()));
  std::copy(entries.begin(), entries.end(), out.begin());
  return out;
}

LinearizedSample scalar(double time, double value, const VectorX& change) { return {time, vector({value}), change}; }

Tolerances numbers(std::size_t count, study::Distribution spread = study::Distribution::normal) {
  return Tolerances(count, study::TolerancedParameter{.path = "x", .width = 1, .distribution = spread});
}

/// Mean and deviation of the larger of two normal figures (Clark 1961, eq. 2 and 3).
std::pair<double, double> larger_of_two(double m1, double m2, const VectorX& a, const VectorX& b) {
  const double theta = (a - b).norm(), alpha = (m1 - m2) / theta;
  const auto density = [](double x) { return std::exp(-x * x / 2) / std::sqrt(2 * std::numbers::pi); };
  const auto below = [](double x) { return std::erfc(-x / std::numbers::sqrt2) / 2; };
  const double mean = m1 * below(alpha) + m2 * below(-alpha) + theta * density(alpha);
  const double square = (m1 * m1 + a.squaredNorm()) * below(alpha) + (m2 * m2 + b.squaredNorm()) * below(-alpha) +
                        (m1 + m2) * theta * density(alpha);
  return {mean, std::sqrt(square - mean * mean)};
}

}  // namespace

TEST_CASE("a peak of two moments is off by what Clark's formula says, whichever signs they have") {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> in(-1, 1);
  for (int trial = 0; trial < 20; ++trial) {
    const double first = 40, second = 40 - std::abs(in(random));
    const VectorX a = vector({in(random), in(random), in(random)}), b = vector({in(random), in(random), in(random)});
    const double sign = trial % 2 == 0 ? 1 : -1;  // a valley is as much a peak
    ExtremeFigure peak({scalar(0, first, a), scalar(1, sign * second, sign * b)}, ExtremeFigure::Kind::peak);
    REQUIRE(peak.has_several_candidates());
    std::vector<ExtremeFigure*> all{&peak};
    sample_extreme_figures(all, numbers(3));
    const double known = larger_of_two(first, second, a, b).second;
    CHECK(std::abs(peak.deviation() - known) < hundredth * known);
  }
}

TEST_CASE("a range's ends are found on their own") {
  // the largest of two that go apart, and a least that stays: E max² = 1, E max = √2 φ(0) · √2
  const VectorX up = vector({1, 0}), down = vector({-1, 0}), other = vector({0, 0.5});
  ExtremeFigure range({scalar(0, 5, up), scalar(1, 5, down), scalar(2, -5, other)}, ExtremeFigure::Kind::range);
  REQUIRE(range.has_several_candidates());
  std::vector<ExtremeFigure*> all{&range};
  sample_extreme_figures(all, numbers(2));
  const double known = std::sqrt(1 - 2 / std::numbers::pi + 0.25);
  CHECK(std::abs(range.deviation() - known) < hundredth * known);
  // as often by the one as by the other
  CHECK(std::abs(range.contributions()[0]) < 3 / std::sqrt(16384.0));
  CHECK(range.contributions()[1] == doctest::Approx(-0.5));
  CHECK(range.extremum_times() == std::vector<double>{0, 1, 2});
}

TEST_CASE("uniform numbers and vectors are drawn as they are") {
  // |(3, 4) + change z| against draws of this test's own
  LinearizedSample one{0, vector({3, 4}), MatrixX::Zero(2, 2)}, two{1, vector({-5, 0}), MatrixX::Zero(2, 2)};
  one.sensitivity << 0.3, 0, 0, 0.2;
  two.sensitivity << 0, 0.1, -0.4, 0;
  ExtremeFigure peak({one, two}, ExtremeFigure::Kind::peak);
  REQUIRE(peak.has_several_candidates());
  std::vector<ExtremeFigure*> all{&peak};
  sample_extreme_figures(all, numbers(2, study::Distribution::uniform));
  std::mt19937_64 random(9);
  std::uniform_real_distribution<double> in(-std::numbers::sqrt3, std::numbers::sqrt3);
  constexpr int count = 200'000;
  double sum = 0, squares = 0;
  for (int k = 0; k < count; ++k) {
    const VectorX z = vector({in(random), in(random)});
    const double largest = std::max((one.value + one.sensitivity.transpose() * z).norm(),
                                    (two.value + two.sensitivity.transpose() * z).norm());
    sum += largest - 5, squares += (largest - 5) * (largest - 5);
  }
  const double known = std::sqrt(squares / count - sum * sum / count / count);
  CHECK(std::abs(peak.deviation() - known) < hundredth * known);
}

TEST_CASE("moments that cannot come up to the largest, or go along with it, are no rivals") {
  const VectorX a = vector({0.1, 0.2});
  CHECK_FALSE(ExtremeFigure({scalar(0, 5, a), scalar(1, 3, -a)}, ExtremeFigure::Kind::peak).has_several_candidates());
  CHECK_FALSE(ExtremeFigure({scalar(0, 5, a), scalar(1, 5, a)}, ExtremeFigure::Kind::peak).has_several_candidates());
  CHECK_FALSE(ExtremeFigure({scalar(0, 5, a), scalar(1, -5, -a)}, ExtremeFigure::Kind::peak).has_several_candidates());
  CHECK(ExtremeFigure({scalar(0, 5, a), scalar(1, 5, -a)}, ExtremeFigure::Kind::peak).has_several_candidates());
}
