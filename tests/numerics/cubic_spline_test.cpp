#include "balance/foundation/numerics/cubic_spline.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <vector>

using namespace balance;
using namespace balance::numerics;

namespace {

struct Taken {
  double value = 0, first = 0, second = 0;
};

Taken take(const CubicSpline& spline, double parameter, int component = 0) {
  VectorX value(spline.size()), first(spline.size()), second(spline.size());
  spline.at(parameter, value, first, second);
  return {value[component], first[component], second[component]};
}

CubicSpline sampled(const std::vector<double>& knots, const std::function<double(double)>& f, SplineEnd end) {
  Samples values(static_cast<Eigen::Index>(knots.size()), 1);
  for (std::size_t i = 0; i < knots.size(); ++i) values(static_cast<Eigen::Index>(i), 0) = f(knots[i]);
  return {knots, values, end};
}

const std::vector<double> uneven{0, 0.3, 0.35, 1, 1.6, 2.5, 2.6};

}  // namespace

TEST_CASE("a spline passes through its points") {
  for (const SplineEnd end : {SplineEnd::natural, SplineEnd::not_a_knot}) {
    const CubicSpline spline = sampled(
        uneven, [](double x) { return std::sin(3 * x); }, end);
    for (const double knot : uneven)
      CHECK(std::abs(take(spline, knot).value - std::sin(3 * knot)) < 1e-15);  // round-off
  }
}

TEST_CASE("value, slope and second derivative of a spline are continuous at its knots") {
  for (const SplineEnd end : {SplineEnd::natural, SplineEnd::not_a_knot}) {
    const CubicSpline spline = sampled(
        uneven, [](double x) { return std::sin(3 * x); }, end);
    for (std::size_t i = 1; i + 1 < uneven.size(); ++i) {
      const Taken left = take(spline, std::nextafter(uneven[i], -1.0)), right = take(spline, uneven[i]);
      // round-off, grown by the division by the shortest interval
      CHECK(std::abs(left.value - right.value) < 1e-14);
      CHECK(std::abs(left.first - right.first) < 1e-12);
      CHECK(std::abs(left.second - right.second) < 1e-11);
    }
  }
}

TEST_CASE("the derivatives of a spline meet central differences") {
  const CubicSpline spline = sampled(
      uneven, [](double x) { return std::exp(x); }, SplineEnd::not_a_knot);
  constexpr double h = 1e-5;
  for (int i = 1; i < 101; ++i) {
    const double x = 2.6 * i / 101;
    const Taken left = take(spline, x - h), here = take(spline, x), right = take(spline, x + h);
    // h² times a third derivative below 1e3; across a knot h times its jump
    CHECK(std::abs((right.value - left.value) / (2 * h) - here.first) < 1e-7);
    CHECK(std::abs((right.first - left.first) / (2 * h) - here.second) < 1e-2);
  }
}

TEST_CASE("not-a-knot reproduces every cubic, on uneven knots, up to and beyond the ends") {
  const auto cubic = [](double x) { return 2 + x * (-1 + x * (0.5 - 3 * x)); };
  for (const std::vector<double>& knots : {uneven, std::vector<double>{0, 0.5, 2, 2.6}}) {
    const CubicSpline spline = sampled(knots, cubic, SplineEnd::not_a_knot);
    for (int i = -2; i <= 28; ++i) {
      const double x = i / 10.0;
      const Taken here = take(spline, x);
      // round-off of values up to 50, grown by the shortest intervals
      CHECK(std::abs(here.value - cubic(x)) < 1e-12);
      CHECK(std::abs(here.first - (-1 + x * (1 - 9 * x))) < 1e-11);
      CHECK(std::abs(here.second - (1 - 18 * x)) < 1e-10);
    }
  }
}

TEST_CASE("natural ends have no second derivative") {
  const CubicSpline spline = sampled(
      uneven, [](double x) { return std::cos(x); }, SplineEnd::natural);
  CHECK(take(spline, 0).second == 0);
  CHECK(take(spline, 2.6).second == 0);
}

TEST_CASE("a not-a-knot spline of a smooth function converges with order 4, its derivatives with 3 and 2") {
  const auto errors = [](int n) {
    std::vector<double> knots;
    for (int i = 0; i <= n; ++i) knots.push_back(2.0 * i / n);
    const CubicSpline spline = sampled(
        knots, [](double x) { return std::sin(2 * x); }, SplineEnd::not_a_knot);
    Taken worst;
    for (int i = 0; i <= 1999; ++i) {
      const double x = 2.0 * i / 1999;
      const Taken here = take(spline, x);
      worst.value = std::max(worst.value, std::abs(here.value - std::sin(2 * x)));
      worst.first = std::max(worst.first, std::abs(here.first - 2 * std::cos(2 * x)));
      worst.second = std::max(worst.second, std::abs(here.second + 4 * std::sin(2 * x)));
    }
    return worst;
  };
  const Taken coarse = errors(64), fine = errors(128);
  // half an order below the theory: the next term of the expansion still shows at these sizes
  CHECK(std::log2(coarse.value / fine.value) > 3.7);
  CHECK(std::log2(coarse.first / fine.first) > 2.7);
  CHECK(std::log2(coarse.second / fine.second) > 1.7);
  CHECK(std::log2(coarse.value / fine.value) < 4.5);  // it is a cubic spline and not something better by accident
}

TEST_CASE("two points make a straight line") {
  const CubicSpline spline = sampled(
      {1, 3}, [](double x) { return 5 * x; }, SplineEnd::natural);
  CHECK(take(spline, 1.5).value == doctest::Approx(7.5));
  CHECK(take(spline, 1.5).first == doctest::Approx(5));
  CHECK(take(spline, 1.5).second == 0);
}

TEST_CASE("a spline needs enough points, in order, each with its values") {
  const auto make = [](std::vector<double> knots, int rows, SplineEnd end) {
    return CubicSpline(std::move(knots), Samples::Zero(rows, 1), end);
  };
  CHECK_NOTHROW(make({0, 1, 2, 3}, 4, SplineEnd::not_a_knot));
  CHECK_THROWS_AS(make({0, 1, 2}, 3, SplineEnd::not_a_knot), std::invalid_argument);
  CHECK_THROWS_AS(make({0}, 1, SplineEnd::natural), std::invalid_argument);
  CHECK_THROWS_AS(make({0, 1, 1}, 3, SplineEnd::natural), std::invalid_argument);
  CHECK_THROWS_AS(make({0, NAN, 1}, 3, SplineEnd::natural), std::invalid_argument);
  CHECK_THROWS_AS(make({0, 1, 2}, 2, SplineEnd::natural), std::invalid_argument);
}

TEST_CASE("a closed spline passes through its points and is smooth at its seam") {
  const double turn = 2 * std::acos(-1.0);
  const std::vector<double> knots{0, 0.7, 1.1, 2.5, 4, 5.5, turn};
  Samples values(7, 1);
  for (Eigen::Index i = 0; i < 7; ++i) values(i, 0) = std::cos(2 * knots[static_cast<std::size_t>(i)]);
  values(6, 0) = values(0, 0);
  const CubicSpline spline(knots, values, SplineEnd::periodic);
  for (Eigen::Index i = 0; i < 7; ++i)
    CHECK(std::abs(take(spline, knots[static_cast<std::size_t>(i)]).value - values(i, 0)) < 1e-15);
  const Taken start = take(spline, 0), end = take(spline, turn);
  CHECK(std::abs(start.first - end.first) < 1e-13);  // round-off of slopes of the order of one
  CHECK(std::abs(start.second - end.second) < 1e-12);
  for (std::size_t i = 1; i < 6; ++i) {
    const Taken left = take(spline, std::nextafter(knots[i], -1.0)), right = take(spline, knots[i]);
    CHECK(std::abs(left.first - right.first) < 1e-12);
    CHECK(std::abs(left.second - right.second) < 1e-11);
  }
}

TEST_CASE("a closed spline through a cosine converges with the fourth power of the step") {
  const double turn = 2 * std::acos(-1.0);
  const auto error = [&](int count) {
    std::vector<double> knots;
    Samples values(count + 1, 1);
    for (int i = 0; i <= count; ++i) {
      knots.push_back(turn * i / count);
      values(i, 0) = std::cos(knots.back());
    }
    values(count, 0) = values(0, 0);
    const CubicSpline spline(knots, values, SplineEnd::periodic);
    double largest = 0;
    for (int i = 0; i < 1000; ++i) {
      const double x = turn * i / 1000;
      largest = std::max(largest, std::abs(take(spline, x).value - std::cos(x)));
    }
    return largest;
  };
  // the error's leading term is h⁴/384 times the fourth derivative; the next one is smaller by h²
  CHECK(error(24) * 384 / std::pow(turn / 24, 4) == doctest::Approx(1).epsilon(0.05));
  CHECK(error(24) / error(48) == doctest::Approx(16).epsilon(0.02));
}

TEST_CASE("a closed spline must end where it starts") {
  CHECK_THROWS_AS(CubicSpline({0, 1, 2, 3}, Samples::Random(4, 1), SplineEnd::periodic), std::invalid_argument);
}
