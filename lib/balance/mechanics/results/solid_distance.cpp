#include "balance/mechanics/results/solid_distance.hpp"

#include "balance/foundation/base/elementary.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace balance::results {

namespace {

Vector3 project_on_segment(const Vector3& point, const Vector3& begin, const Vector3& end) {
  const Vector3 along = end - begin;
  const double square = along.squaredNorm();
  if (!(square > 0)) return begin;
  return begin + std::clamp((point - begin).dot(along) / square, 0.0, 1.0) * along;
}

/// Of the plane of the arcs, from their axis.
Vector3 project_on_disc(const Vector3& point, double radius) {
  const double distance = std::hypot(point.x(), point.y());
  if (distance <= radius) return {point.x(), point.y(), 0};
  return {point.x() * radius / distance, point.y() * radius / distance, 0};
}

Vector3 project_on_sector(const Vector3& point, double radius, double opening) {
  if (opening > std::numbers::pi) return project_on_disc(point, radius);
  const double c = elementary::cos(opening / 2), s = elementary::sin(opening / 2);
  const Vector3 p(point.x(), point.y(), 0);
  // the half plane of each edge: inside if both agree
  const double upper = s * p.x() - c * p.y(), lower = s * p.x() + c * p.y();
  if (upper >= 0 && lower >= 0) return project_on_disc(p, radius);
  const Vector3 first = project_on_segment(p, Vector3::Zero(), {radius * c, radius * s, 0});
  const Vector3 second = project_on_segment(p, Vector3::Zero(), {radius * c, -radius * s, 0});
  return (first - p).squaredNorm() <= (second - p).squaredNorm() ? first : second;
}

}  // namespace

Vector3 ConvexSet::project(const Vector3& point) const {
  if (shape == nullptr) return project_on_segment(point, begin, end);
  Vector3 p = rotation.transpose() * (point - centre), nearest = Vector3::Zero();
  switch (shape->kind) {
    case model::ShapeKind::cylinder:
    case model::ShapeKind::ring: nearest = project_on_disc(p, shape->diameter / 2); break;
    case model::ShapeKind::sector: {
      const Vector3 axis(shape->axis_distance, 0, 0);  // from the arcs' axis to the centre of mass
      nearest = project_on_sector(p + axis, shape->diameter / 2, shape->opening) - axis;
      break;
    }
    case model::ShapeKind::plate:
      nearest = {std::clamp(p.x(), -shape->length / 2, shape->length / 2),
                 std::clamp(p.y(), -shape->width / 2, shape->width / 2), 0};
      break;
  }
  nearest.z() = is_planar ? 0 : std::clamp(p.z(), -shape->thickness / 2, shape->thickness / 2);
  return centre + rotation * nearest;
}

double distance_of(const ConvexSet& a, const ConvexSet& b) {
  constexpr int max_projections = 2000;
  constexpr double tolerance = 1e-12;
  Vector3 on_b = b.shape == nullptr ? b.begin : b.centre, on_a = a.project(on_b);
  double distance = (on_a - on_b).norm();
  for (int k = 0; k < max_projections; ++k) {
    on_b = b.project(on_a);
    on_a = a.project(on_b);
    const double next = (on_a - on_b).norm();
    const bool is_done = distance - next <= tolerance * (1e-3 + distance);
    distance = next;
    if (is_done) break;
  }
  const double scale = on_a.norm() + on_b.norm();
  return distance <= 1e-14 * scale ? 0 : distance;
}

}  // namespace balance::results
