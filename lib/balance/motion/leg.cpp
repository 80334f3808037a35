#include "balance/motion/leg.hpp"

#include "balance/base/factorizations.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <utility>

namespace balance {
namespace {

using Request = PrescribedMotion::Request;

std::string format_value_count(Eigen::Index n) { return std::to_string(n) + (n == 1 ? " value" : " values"); }

void require_values(const Request& request, const DriveValue& given, const std::string& name) {
  if (given.value.size() != request.from.value.size()) {
    throw std::invalid_argument("the motion starts with " + format_value_count(request.from.value.size()) + ", but " +
                                name + " has " + format_value_count(given.value.size()));
  }
  if (!given.value.allFinite()) throw std::invalid_argument(name + " of the motion must be finite numbers");
  if (!request.has_rotation) return;
  const Matrix3 error = given.rotation * given.rotation.transpose() - Matrix3::Identity();
  // NaN fails as well; the bound admits rotations that were typed with some six digits
  if (!(error.norm() < 1e-5) || !(given.rotation.determinant() > 0)) {
    throw std::invalid_argument("the orientation at " + name + " of the motion is not a rotation");
  }
}

void validate_request(const Request& request) {
  if (!(request.duration > 0) || !std::isfinite(request.duration)) {
    throw std::invalid_argument("the duration of a motion must be positive, is " + std::to_string(request.duration) +
                                " s");
  }
  validate(request.law);
  require_values(request, request.from, "the start");
  if (request.from.value.size() == 0 && !request.has_rotation)
    throw std::invalid_argument("the motion prescribes nothing");
  if (request.position_components < 0 ||
      request.position_components > std::min<Eigen::Index>(3, request.from.value.size())) {
    throw std::invalid_argument("a motion of " + format_value_count(request.from.value.size()) +
                                " cannot lead with the " + std::to_string(request.position_components) +
                                " coordinates of a point");
  }
}

StraightCurve make_line(const DriveValue& from, const DriveValue& to) { return {from.value, to.value - from.value}; }

RotationCurve make_rotation_between(const Request& request, const DriveValue& from, const DriveValue& to) {
  if (!request.has_rotation) return NoRotation{};
  return find_shortest_rotation(from.rotation, to.rotation);
}

TimeScaling make_full_time_scaling(const Request& request) {
  return {request.law, 0, request.duration, time_tolerance * request.duration};
}

SegmentedPath make_single_segment(const Request& request, Curve curve, RotationCurve turn) {
  SegmentedPath result{
      .duration = request.duration, .size = static_cast<int>(request.from.value.size()), .segments = {}};
  result.segments.push_back({make_full_time_scaling(request), std::move(curve), std::move(turn)});
  return result;
}

SegmentedPath make_itinerary(const Request& request, const LinePath&) {
  validate_request(request);
  require_values(request, request.to, "the end");
  return make_single_segment(request, make_line(request.from, request.to),
                             make_rotation_between(request, request.from, request.to));
}

SegmentedPath make_itinerary(const Request& request, const ArcPath& path) {
  validate_request(request);
  require_values(request, request.to, "the end");
  return make_single_segment(request,
                             make_circular_arc(make_line(request.from, request.to), request.position_components, path),
                             make_rotation_between(request, request.from, request.to));
}

SegmentedPath make_itinerary(const Request& request, const CirclePath& path) {
  validate_request(request);
  const bool stays = request.to.value.size() == 0;  // nothing but the point moves
  if (!stays) require_values(request, request.to, "the end");
  const DriveValue& to = stays ? request.from : request.to;
  return make_single_segment(request, make_circle(make_line(request.from, to), request.position_components, path),
                             make_rotation_between(request, request.from, to));
}

SegmentedPath make_stopping_segments(const Request& request, const std::vector<DriveValue>& points,
                                     const std::vector<double>& fractions) {
  SegmentedPath result{
      .duration = request.duration, .size = static_cast<int>(request.from.value.size()), .segments = {}};
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double start = fractions[i - 1] * request.duration;
    const TimeScaling clock(request.law, start, fractions[i] * request.duration - start,
                            time_tolerance * request.duration);
    result.segments.push_back(
        {clock, make_line(points[i - 1], points[i]), make_rotation_between(request, points[i - 1], points[i])});
  }
  return result;
}

/// The ends are natural, not clamped: the law already brings the motion to rest, so a curve whose own slope vanished
/// there would only crowd the motion into the middle. Of all curves through the points the natural spline bends least.
SegmentedPath make_spline_segment(const Request& request, const std::vector<DriveValue>& points,
                                  std::vector<double> knots) {
  Samples values(static_cast<Eigen::Index>(points.size()), request.from.value.size());
  std::vector<Matrix3> rotations;
  for (std::size_t i = 0; i < points.size(); ++i) {
    values.row(static_cast<Eigen::Index>(i)) = points[i].value.transpose();
    rotations.push_back(points[i].rotation);
  }
  RotationCurve turn = NoRotation{};
  if (request.has_rotation) turn = interpolate_rotations(knots, rotations);
  return make_single_segment(request, SplineCurve{CubicSpline(std::move(knots), std::move(values), SplineEnd::natural)},
                             std::move(turn));
}

/// Where the law stands when the waypoints are due: stated fractions are times, the spline's knots are values of the
/// law.
std::vector<double> evaluate_law_at(const MotionLaw& law, std::vector<double> fractions) {
  for (double& fraction : fractions) fraction = evaluate(law, fraction).s;
  for (std::size_t i = 1; i < fractions.size(); ++i) {
    if (fractions[i] - fractions[i - 1] > time_tolerance) continue;
    throw std::invalid_argument("the law of motion hardly moves between the fractions of waypoints " +
                                std::to_string(i - 1) + " and " + std::to_string(i) +
                                " (0 is the start): a spline needs them further apart");
  }
  return fractions;
}

SegmentedPath make_itinerary(const Request& request, const WaypointPath& path) {
  validate_request(request);
  require_values(request, request.to, "the end");
  if (request.via.empty()) throw std::invalid_argument("a path through waypoints needs at least one waypoint");
  std::vector<DriveValue> points{request.from};
  for (const DriveValue& point : request.via) {
    require_values(request, point, "waypoint " + std::to_string(points.size()));
    points.push_back(point);
  }
  points.push_back(request.to);
  const std::vector<double> fractions =
      compute_waypoint_fractions(points, path.fractions, request.position_components, request.has_rotation);
  if (!path.spline) return make_stopping_segments(request, points, fractions);
  return make_spline_segment(request, points,
                             path.fractions.empty() ? fractions : evaluate_law_at(request.law, fractions));
}

/// Times as parts of the table's duration, so that a uniform law runs through it like through any other curve.
std::vector<double> table_knots(const TablePath& path) {
  if (path.time.size() < 4) {
    throw std::invalid_argument("a table of a motion needs at least 4 rows, has " + std::to_string(path.time.size()));
  }
  if (path.values.size() != path.time.size()) {
    throw std::invalid_argument("a table of a motion has " + std::to_string(path.time.size()) + " times but " +
                                std::to_string(path.values.size()) + " rows of values");
  }
  const double first = path.time.front(), duration = path.time.back() - first;
  std::vector<double> knots;
  for (std::size_t i = 0; i < path.time.size(); ++i) {
    knots.push_back((path.time[i] - first) / duration);
    if (std::isfinite(path.time[i]) && (i == 0 || (path.time[i] > path.time[i - 1] && knots[i] > knots[i - 1])))
      continue;
    throw std::invalid_argument("the times of a table must increase: row " + std::to_string(i + 1) + " has " +
                                std::to_string(path.time[i]) + " s");
  }
  return knots;
}

Samples table_values(const TablePath& path) {
  const std::size_t columns = path.values.front().size();
  Samples values(static_cast<Eigen::Index>(path.values.size()), static_cast<Eigen::Index>(columns));
  for (std::size_t i = 0; i < path.values.size(); ++i) {
    const std::vector<double>& row = path.values[i];
    const bool finite = std::all_of(row.begin(), row.end(), [](double x) { return std::isfinite(x); });
    if (row.size() != columns || !finite) {
      throw std::invalid_argument("row " + std::to_string(i + 1) + " of the motion's table must have " +
                                  format_value_count(static_cast<Eigen::Index>(columns)) + ", finite numbers; it has " +
                                  format_value_count(static_cast<Eigen::Index>(row.size())));
    }
    for (std::size_t c = 0; c < columns; ++c)
      values(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(c)) = row[c];
  }
  return values;
}

SegmentedPath make_itinerary(const Request& request, const TablePath& path) {
  const std::vector<double> knots = table_knots(path);
  const Samples all = table_values(path);
  const Eigen::Index size = all.cols() - (request.has_rotation ? 3 : 0);
  const Eigen::Index asked = request.from.value.size();
  if (size < 0 || all.cols() == 0 || (asked != 0 && asked != size)) {
    throw std::invalid_argument("the motion's table has " + format_value_count(all.cols()) +
                                " in a row, but the drive has " +
                                format_value_count(asked + (request.has_rotation ? 3 : 0)));
  }
  SegmentedPath result{
      .duration = path.time.back() - path.time.front(), .size = static_cast<int>(size), .segments = {}};
  RotationCurve turn = NoRotation{};
  if (request.has_rotation) turn = interpolate_rotation_vectors(knots, all.rightCols(3));
  const TimeScaling clock({.kind = MotionLawKind::uniform}, 0, result.duration, time_tolerance * result.duration);
  result.segments.push_back(
      {clock, SplineCurve{CubicSpline(knots, all.leftCols(size), SplineEnd::not_a_knot)}, std::move(turn)});
  return result;
}

}  // namespace

SegmentedPath make_segmented_path(const PrescribedMotion::Request& request) {
  return std::visit([&](const auto& path) { return make_itinerary(request, path); }, request.path);
}

}  // namespace balance
