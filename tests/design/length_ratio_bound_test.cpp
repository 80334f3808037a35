// Lower bounds of the efforts of springs over boxes of places and rows, against the efforts at points of them.

#include "balance/synthesis/design/length_ratio_bound.hpp"
#include "balance/foundation/numerics/random.hpp"

#include <doctest/doctest.h>

#include <cmath>

using namespace balance;
using namespace balance::design;

namespace {

// A spring from (x, y) of the ground to (r, 0) of an arm at angles θ, and a weight: the torque is
// y₀ + (1 − ε/l) k r (x sin θ − y cos θ). Features 1, a = (x, y), b = (r, 0), a bᵀ, |a|² + |b|².
constexpr int samples = 15, features = 9;
constexpr double weight = 2.2;

double angle(Eigen::Index i) { return -0.75 + 1.7 * static_cast<double>(i) / (samples - 1); }

VectorX time_weights() { return VectorX::Constant(samples, 1.0 / samples); }

SpringSeries arm(bool is_peak = false) {
  MatrixX torque = MatrixX::Zero(samples, features);
  SquaredLengths lengths{MatrixX::Zero(samples, features + 1), {}};
  VectorX constant(samples);
  for (Eigen::Index i = 0; i < samples; ++i) {
    const double c = std::cos(angle(i)), s = std::sin(angle(i));
    constant[i] = weight * c;
    torque(i, 5) = s, torque(i, 7) = -c;
    lengths.rows(i, 5) = -2 * c, lengths.rows(i, 7) = -2 * s, lengths.rows(i, features) = 1;
  }
  lengths.mean = lengths.rows.colwise().mean().transpose();
  return {1, is_peak, time_weights(), constant, {torque}, {lengths}};
}

struct Box {
  VectorX lower, upper;  ///< r, x, y, cable
  Interval stiffness, free_length;
};

std::vector<SpringRange> range(const SpringSeries& series, const Box& box) {
  const BoxAlgebra algebra(4);
  std::array<BoxForm, 4> p;
  VectorX m(4);
  for (int j = 0; j < 4; ++j) {
    p[static_cast<std::size_t>(j)] = algebra.place(j, {box.lower[j], box.upper[j]});
    m[j] = p[static_cast<std::size_t>(j)].value.middle();
  }
  const BoxForm zero = algebra.constant(0.0);
  const BoxForm size = algebra.add(algebra.square(p[0]), algebra.add(algebra.square(p[1]), algebra.square(p[2])));
  SpringRange spring;
  spring.features = {algebra.constant(1.0),        p[1], p[2], p[0], zero, algebra.multiply(p[1], p[0]), zero,
                     algebra.multiply(p[2], p[0]), zero, size};
  spring.middle_features = {1, m[1], m[2], m[0], 0, m[1] * m[0], 0, m[2] * m[0], 0, m.head(3).squaredNorm()};
  for (const int f : series.parts[0].features) {
    spring.forces.push_back(algebra.scale(spring.features[static_cast<std::size_t>(f)], box.stiffness));
    spring.middle_forces.push_back(box.stiffness * spring.middle_features[static_cast<std::size_t>(f)]);
  }
  spring.free_length = algebra.add(p[3], algebra.constant(box.free_length));
  spring.middle_free_length = Interval(m[3]) + box.free_length;
  for (Eigen::Index i = 0; i < samples; ++i)
    spring.squares.push_back(square(p[1].value - p[0].value * std::cos(angle(i))) +
                             square(p[2].value - p[0].value * std::sin(angle(i))));
  return {spring};
}

double torque(const VectorX& p, double stiffness, double free_length, bool is_peak) {
  double sum = 0, largest = 0;
  for (Eigen::Index i = 0; i < samples; ++i) {
    const double c = std::cos(angle(i)), s = std::sin(angle(i));
    const double length = std::hypot(p[1] - p[0] * c, p[2] - p[0] * s);
    const double y = weight * c + (1 - (free_length + p[3]) / length) * stiffness * p[0] * (p[1] * s - p[2] * c);
    sum += y * y / samples;
    largest = std::max(largest, std::abs(y));
  }
  return is_peak ? largest : std::sqrt(sum);
}

/// A box about a place where the spring nearly balances the weight.
Box box_near_balance(numerics::UniformRandom& random, double size) {
  VectorX p(4);
  p << random(0.02, 0.05), random(-0.03, 0.03), random(0.12, 0.25), random(0, 0.03);
  const double free_length = random(0.02, 0.06), length = p.segment(1, 2).norm();
  const double stiffness = weight / (p[0] * p[2] * (1 - (free_length + p[3]) / length)) * random(0.98, 1.02);
  VectorX half = size * p.cwiseAbs();
  half[1] = size * p[2];
  return {p - half,
          p + half,
          {stiffness * (1 - size), stiffness * (1 + size)},
          {free_length * (1 - size), free_length * (1 + size)}};
}

}  // namespace

TEST_CASE("no place of a box is below its bound, and none that is below the cutoff is cut off") {
  numerics::UniformRandom random(1);
  int cut_off = 0, bounded = 0, below = 0;
  for (const bool is_peak : {false, true}) {
    const SpringSeries series = arm(is_peak);
    for (int k = 0; k < 400; ++k) {
      const double size = std::pow(10.0, random(-4, -0.7));
      const Box box = box_near_balance(random, size);
      const double cutoff = std::pow(10.0, random(-3, -0.5));
      PlaceRange places(0.5 * (box.upper - box.lower));
      const LengthRatioBound bound = bound_by_length_ratios(series, range(series, box), cutoff, places);
      cut_off += !bound.is_feasible, bounded += bound.is_feasible && bound.lower > 0;
      for (int n = 0; n < 60; ++n) {
        VectorX p(4), offset(4);
        for (int j = 0; j < 4; ++j) {
          offset[j] = 0.5 * (box.upper[j] - box.lower[j]) * random(-1, 1);
          p[j] = 0.5 * (box.upper[j] + box.lower[j]) + offset[j];
        }
        const double value = torque(p, random(box.stiffness.lower, box.stiffness.upper),
                                    random(box.free_length.lower, box.free_length.upper), is_peak);
        if (value > cutoff) continue;
        ++below;
        CHECK(bound.is_feasible);
        CHECK(bound.lower <= value * (1 + 1e-12));
        for (std::size_t j = 0; j < 4; ++j) {
          const Interval& left = places.ranges()[j];
          const double round_off = 1e-12 * (box.upper[static_cast<Eigen::Index>(j)] + 0.1);
          CHECK(offset[static_cast<Eigen::Index>(j)] >= left.lower - round_off);
          CHECK(offset[static_cast<Eigen::Index>(j)] <= left.upper + round_off);
        }
      }
    }
  }
  // all kinds of boxes occurred
  CHECK(cut_off > 50);
  CHECK(bounded > 50);
  CHECK(below > 1000);
}

TEST_CASE("the bound of a small box is near the effort at its middle, in proportion to it") {
  numerics::UniformRandom random(2);
  const SpringSeries series = arm();
  for (int k = 0; k < 50; ++k) {
    const Box box = box_near_balance(random, 1e-7);
    const double value = torque(0.5 * (box.lower + box.upper), box.stiffness.middle(), box.free_length.middle(), false);
    PlaceRange places(0.5 * (box.upper - box.lower));
    const LengthRatioBound bound = bound_by_length_ratios(series, range(series, box), 10, places);
    REQUIRE(bound.is_feasible);
    // efforts change by a few weights per relative change of a place
    CHECK(bound.lower >= value - 50e-7 * weight);
  }
}
