#include "balance/motion/turn.hpp"

#include "balance/base/elementary.hpp"
#include "balance/base/rotation.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

namespace balance {
namespace {

constexpr double two_pi = 2 * std::numbers::pi;

/// The functions of the angle θ = |φ| in the velocity of exp(φ): a = (1 − cos θ)/θ², b = (θ − sin θ)/θ³, and a'/θ,
/// b'/θ.
struct ExponentialMapCoefficients {
  double a = 0, b = 0, da = 0, db = 0;
};

ExponentialMapCoefficients compute_exponential_map_coefficients(double squared) {
  ExponentialMapCoefficients f;
  if (squared > 0.25) {
    const double angle = std::sqrt(squared);
    const auto [sine, cosine] = sine_cosine(angle);
    f.a = (1 - cosine) / squared;
    f.b = (angle - sine) / (squared * angle);
    f.da = (sine / angle - 2 * f.a) / squared;
    f.db = (f.a - 3 * f.b) / squared;
    return f;
  }
  // Power series in x = θ², where the closed forms cancel: a = Σ (−x)ⁿ/(2n+2)!, b = Σ (−x)ⁿ/(2n+3)!, a'/θ = 2 da/dx.
  // Eight terms leave less than 1e-17 for x ≤ 1/4.
  double term = 0.5, power = 0;  // (−x)ⁿ/(2n+2)! and the same with xⁿ⁻¹, sign kept
  for (int n = 0; n < 8; ++n) {
    f.a += term;
    f.b += term / (2 * n + 3);
    f.da += 2 * n * power;
    f.db += 2 * n * power / (2 * n + 3);
    const double next = -1.0 / ((2 * n + 3) * (2 * n + 4));
    power = term * next;
    term = power * squared;
  }
  return f;
}

/// Of all rotation vectors of the rotation exp(vector), the one nearest to `reference`.
Vector3 find_nearest_rotation_vector(const Vector3& vector, const Vector3& reference) {
  const double angle = vector.norm();
  if (angle < 1e-12) {  // no axis of its own: whole turns about the reference's
    const double whole = std::round(reference.norm() / two_pi);
    return whole == 0 ? vector : Vector3(vector + whole * two_pi * reference.normalized());
  }
  const Vector3 axis = vector / angle;
  return vector + two_pi * std::round((reference.dot(axis) - angle) / two_pi) * axis;
}

Vector3 row(const Samples& vectors, std::size_t i) { return vectors.row(static_cast<Eigen::Index>(i)).transpose(); }

/// A rotation vector far from zero moves much faster than its rotation, and a spline through such vectors would wobble.
void require_close_rotations(const Vector3& left, const Vector3& right, const Matrix3& from, const Matrix3& to,
                             std::size_t i) {
  const double angle = rotation_vector_of(to * from.transpose()).norm();
  if ((right - left).norm() <= 2 * angle + 1e-9) return;
  throw std::invalid_argument(
      "the orientations " + std::to_string(i) + " and " + std::to_string(i + 1) +
      " of the spline lie too far from its middle one for a smooth rotation through all of them: "
      "stop at the waypoints instead of going through in one spline, or split the motion");
}

}  // namespace

void NoRotation::fill(const MotionLawValue&, DriveSample& sample) const {
  sample.rotation.setIdentity();
  sample.angular_velocity.setZero();
  sample.angular_acceleration.setZero();
}

void FixedAxisRotation::fill(const MotionLawValue& progress, DriveSample& sample) const {
  sample.rotation.noalias() = rotation_about(axis, angle * progress.s) * start;
  sample.angular_velocity = angle * progress.ds * axis;
  sample.angular_acceleration = angle * progress.dds * axis;
}

/// ω = φ' + a φ × φ' + b φ × (φ × φ'), and its derivative.
void SplineRotation::fill(const MotionLawValue& progress, DriveSample& sample) const {
  Vector3 phi, rate, acceleration;
  rotation_vector.at(progress.s, phi, rate, acceleration);
  acceleration = Vector3(acceleration * (progress.ds * progress.ds) + rate * progress.dds);
  rate *= progress.ds;
  const ExponentialMapCoefficients f = compute_exponential_map_coefficients(phi.squaredNorm());
  const Vector3 cross = phi.cross(rate), double_cross = phi.cross(cross);
  const Vector3 cross_rate = phi.cross(acceleration);
  const Vector3 double_cross_rate = rate.cross(cross) + phi.cross(cross_rate);
  const double half_growth = phi.dot(rate);  // half of d|φ|²/dt
  sample.rotation.noalias() = rotation_from_rotation_vector(phi) * reference;
  sample.angular_velocity = rate + f.a * cross + f.b * double_cross;
  sample.angular_acceleration =
      acceleration + f.a * cross_rate + f.b * double_cross_rate + half_growth * (f.da * cross + f.db * double_cross);
}

FixedAxisRotation find_shortest_rotation(const Matrix3& from, const Matrix3& to) {
  const Vector3 vector = rotation_vector_of(to * from.transpose());
  const double angle = vector.norm();
  return {from, angle == 0 ? Vector3(Vector3::UnitZ()) : Vector3(vector / angle), angle};
}

SplineRotation interpolate_rotations(const std::vector<double>& knots, const std::vector<Matrix3>& rotations) {
  // Counted from the middle the vectors stay shortest, and the curve does not depend on the direction of travel.
  const std::size_t middle = rotations.size() / 2;
  const Matrix3& reference = rotations[middle];
  Samples vectors(static_cast<Eigen::Index>(rotations.size()), 3);
  const auto vector_of = [&](std::size_t i) { return rotation_vector_of(rotations[i] * reference.transpose()); };
  const auto put = [&](std::size_t i, const Vector3& neighbour) {
    vectors.row(static_cast<Eigen::Index>(i)) = find_nearest_rotation_vector(vector_of(i), neighbour).transpose();
  };
  put(middle, Vector3::Zero());
  for (std::size_t i = middle + 1; i < rotations.size(); ++i) put(i, row(vectors, i - 1));
  for (std::size_t i = middle; i-- > 0;) put(i, row(vectors, i + 1));
  for (std::size_t i = 1; i < rotations.size(); ++i) {
    require_close_rotations(row(vectors, i - 1), row(vectors, i), rotations[i - 1], rotations[i], i);
  }
  return {reference, CubicSpline(knots, std::move(vectors), SplineEnd::natural)};
}

SplineRotation interpolate_rotation_vectors(const std::vector<double>& knots, Samples vectors) {
  for (Eigen::Index i = 1; i < vectors.rows(); ++i) {
    const Vector3 before = vectors.row(i - 1).transpose(), here = vectors.row(i).transpose();
    vectors.row(i) = find_nearest_rotation_vector(here, before).transpose();
  }
  return {Matrix3::Identity(), CubicSpline(knots, std::move(vectors), SplineEnd::not_a_knot)};
}

}  // namespace balance
