#include "balance/motion/curve.hpp"

#include "balance/base/elementary.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

namespace balance {
namespace {

/// Smaller than this, relative to the lengths at hand, a distance counts as zero.
constexpr double relative_length_epsilon = 1e-9;

void require_point(int dimensions, const std::string& what) {
  if (dimensions == 2 || dimensions == 3) return;
  throw std::invalid_argument(what + " needs a drive that prescribes the position of a point (x and y, or x, y and z)");
}

Vector3 leading_point(const VectorX& value, int dimensions) {
  Vector3 point = Vector3::Zero();
  point.head(dimensions) = value.head(dimensions);
  return point;
}

}  // namespace

void StraightCurve::fill(const MotionLawValue& progress, DriveSample& sample) const {
  for (Eigen::Index i = 0; i < start.size(); ++i) {
    sample.value[i] = start[i] + progress.s * delta[i];
    sample.rate[i] = progress.ds * delta[i];
    sample.acceleration[i] = progress.dds * delta[i];
  }
}

void CircularCurve::fill(const MotionLawValue& progress, DriveSample& sample) const {
  straight_part.fill(progress, sample);
  const double rate = sweep * progress.ds, acceleration = sweep * progress.dds;
  const auto [sine, cosine] = sine_cosine(sweep * progress.s);
  for (int i = 0; i < dimensions; ++i) {
    const double outward = cosine * u[i] + sine * v[i], along = cosine * v[i] - sine * u[i];
    sample.value[i] = centre[i] + outward;
    sample.rate[i] = rate * along;
    sample.acceleration[i] = acceleration * along - rate * rate * outward;
  }
}

void SplineCurve::fill(const MotionLawValue& progress, DriveSample& sample) const {
  spline.at(progress.s, sample.value, sample.rate, sample.acceleration);
  const double squared = progress.ds * progress.ds;
  for (Eigen::Index i = 0; i < sample.value.size(); ++i) {
    sample.acceleration[i] = sample.acceleration[i] * squared + sample.rate[i] * progress.dds;
    sample.rate[i] *= progress.ds;
  }
}

CircularCurve make_circle(const StraightCurve& rest, int dimensions, const CirclePath& path) {
  require_point(dimensions, "a circular path");
  if (!path.centre.head(dimensions).allFinite() || !std::isfinite(path.angle) || path.angle == 0) {
    throw std::invalid_argument("a circular path needs a centre and an angle that is not zero");
  }
  const double length = path.normal.norm();
  if (!(length > 0) || !std::isfinite(length))
    throw std::invalid_argument("the normal of a circular path must not be zero");
  const Vector3 normal = path.normal / length;
  if (dimensions == 2 && normal.head<2>().norm() > relative_length_epsilon) {
    throw std::invalid_argument(
        "a circular path of two coordinates must lie in their plane: its normal is at right angles to both");
  }
  const Vector3 start = leading_point(rest.start, dimensions), centre = leading_point(path.centre, dimensions);
  const Vector3 axial = (start - centre).dot(normal) * normal;
  CircularCurve curve{
      .straight_part = rest, .dimensions = dimensions, .centre = centre + axial, .u = {}, .v = {}, .sweep = path.angle};
  curve.u = start - curve.centre;
  curve.v = normal.cross(curve.u);
  if (curve.u.norm() <= relative_length_epsilon * std::max(start.norm(), centre.norm())) {
    throw std::invalid_argument("a circular path must not start at its own centre or on its axis");
  }
  return curve;
}

CircularCurve make_circular_arc(const StraightCurve& rest, int dimensions, const ArcPath& path) {
  require_point(dimensions, "an arc");
  const Vector3 start = leading_point(rest.start, dimensions);
  const Vector3 a = leading_point(path.via, dimensions) - start;  // start → via
  const Vector3 b = leading_point(rest.delta, dimensions);        // start → end
  if (!a.allFinite()) throw std::invalid_argument("the point that an arc goes through must be finite numbers");
  const Vector3 n = a.cross(b);
  const double size = std::max({a.norm(), b.norm(), (b - a).norm()});
  if (!(n.norm() > relative_length_epsilon * size * size)) {
    throw std::invalid_argument(
        "the start, the via point and the end of an arc lie on one line: no circle goes through them");
  }
  const Vector3 from_start = (a.squaredNorm() * b.cross(n) + b.squaredNorm() * n.cross(a)) / (2 * n.squaredNorm());
  // Seen along n the points come in the order start, via, end, so the sweep is the positive angle to the end.
  CircularCurve curve{.straight_part = rest,
                      .dimensions = dimensions,
                      .centre = start + from_start,
                      .u = -from_start,
                      .v = {},
                      .sweep = 0};
  curve.v = n.normalized().cross(curve.u);
  const Vector3 end = b - from_start;
  const double angle = elementary::atan2(end.dot(curve.v), end.dot(curve.u));
  curve.sweep = angle > 0 ? angle : angle + 2 * std::numbers::pi;
  return curve;
}

}  // namespace balance
