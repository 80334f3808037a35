#include "balance/mechanics/trajectory/geometric_path.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/rotation.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

namespace balance::trajectory {
namespace {

/// Distances below this, relative to the lengths involved, count as zero.
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

CircularCurve make_circle(const StraightCurve& straight, int dimensions, const CirclePath& path) {
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
        "a circular path of two coordinates must lie in their plane: its normal must be perpendicular to both");
  }
  const Vector3 start = leading_point(straight.start, dimensions), centre = leading_point(path.centre, dimensions);
  const Vector3 axial = (start - centre).dot(normal) * normal;
  CircularCurve curve{.straight_part = straight,
                      .dimensions = dimensions,
                      .centre = centre + axial,
                      .u = {},
                      .v = {},
                      .sweep = path.angle};
  curve.u = start - curve.centre;
  curve.v = normal.cross(curve.u);
  if (curve.u.norm() <= relative_length_epsilon * std::max(start.norm(), centre.norm())) {
    throw std::invalid_argument("a circular path must not start at its own centre or on its axis");
  }
  return curve;
}

CircularCurve make_circular_arc(const StraightCurve& straight, int dimensions, const ArcPath& path) {
  require_point(dimensions, "an arc");
  const Vector3 start = leading_point(straight.start, dimensions);
  const Vector3 a = leading_point(path.via, dimensions) - start;  // start → via
  const Vector3 b = leading_point(straight.delta, dimensions);    // start → end
  if (!a.allFinite()) throw std::invalid_argument("the via point of an arc must have finite coordinates");
  const Vector3 n = a.cross(b);
  const double size = std::max({a.norm(), b.norm(), (b - a).norm()});
  if (!(n.norm() > relative_length_epsilon * size * size)) {
    throw std::invalid_argument(
        "the start, the via point and the end of an arc lie on one line: no circle goes through them");
  }
  const Vector3 from_start = (a.squaredNorm() * b.cross(n) + b.squaredNorm() * n.cross(a)) / (2 * n.squaredNorm());
  // Seen along n, the points come in the order start, via, end, so the sweep is the positive angle to the end.
  CircularCurve curve{.straight_part = straight,
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

namespace {

using Request = PrescribedMotion::Request;

std::string format_value_count(Eigen::Index n) { return std::to_string(n) + (n == 1 ? " value" : " values"); }

void require_values(const Request& request, const DriveValue& drive_value, const std::string& name) {
  if (drive_value.value.size() != request.from.value.size()) {
    throw std::invalid_argument("the motion starts with " + format_value_count(request.from.value.size()) + ", but " +
                                name + " has " + format_value_count(drive_value.value.size()));
  }
  if (!drive_value.value.allFinite())
    throw std::invalid_argument(name + " of the motion must consist of finite numbers");
  if (!request.has_rotation) return;
  const Matrix3 error = drive_value.rotation * drive_value.rotation.transpose() - Matrix3::Identity();
  // NaN fails as well; the tolerance admits rotations typed with about six digits
  if (!(error.norm() < 1e-5) || !(drive_value.rotation.determinant() > 0)) {
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
                                " cannot start with the " + std::to_string(request.position_components) +
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

SegmentedPath make_single_segment(const Request& request, Curve curve, RotationCurve rotation) {
  SegmentedPath result{
      .duration = request.duration, .size = static_cast<int>(request.from.value.size()), .segments = {}};
  result.segments.push_back({make_full_time_scaling(request), std::move(curve), std::move(rotation)});
  return result;
}

SegmentedPath make_path(const Request& request, const LinePath&) {
  validate_request(request);
  require_values(request, request.to, "the end");
  return make_single_segment(request, make_line(request.from, request.to),
                             make_rotation_between(request, request.from, request.to));
}

SegmentedPath make_path(const Request& request, const ArcPath& path) {
  validate_request(request);
  require_values(request, request.to, "the end");
  return make_single_segment(request,
                             make_circular_arc(make_line(request.from, request.to), request.position_components, path),
                             make_rotation_between(request, request.from, request.to));
}

SegmentedPath make_path(const Request& request, const CirclePath& path) {
  validate_request(request);
  const bool keeps_start = request.to.value.size() == 0;  // only the point moves
  if (!keeps_start) require_values(request, request.to, "the end");
  const DriveValue& to = keeps_start ? request.from : request.to;
  return make_single_segment(request, make_circle(make_line(request.from, to), request.position_components, path),
                             make_rotation_between(request, request.from, to));
}

SegmentedPath make_stopping_segments(const Request& request, const std::vector<DriveValue>& points,
                                     const std::vector<double>& fractions) {
  SegmentedPath result{
      .duration = request.duration, .size = static_cast<int>(request.from.value.size()), .segments = {}};
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double start = fractions[i - 1] * request.duration;
    const TimeScaling time_scaling(request.law, start, fractions[i] * request.duration - start,
                                   time_tolerance * request.duration);
    result.segments.push_back(
        {time_scaling, make_line(points[i - 1], points[i]), make_rotation_between(request, points[i - 1], points[i])});
  }
  return result;
}

/// Natural rather than clamped ends: the law already brings the motion to rest, and a curve with zero slope at the ends
/// would only concentrate the motion in the middle. The natural spline has minimum bending among all curves through the
/// points.
SegmentedPath make_spline_segment(const Request& request, const std::vector<DriveValue>& points,
                                  std::vector<double> knots) {
  Samples values(static_cast<Eigen::Index>(points.size()), request.from.value.size());
  std::vector<Matrix3> rotations;
  for (std::size_t i = 0; i < points.size(); ++i) {
    values.row(static_cast<Eigen::Index>(i)) = points[i].value.transpose();
    rotations.push_back(points[i].rotation);
  }
  RotationCurve rotation = NoRotation{};
  if (request.has_rotation) rotation = interpolate_rotations(knots, rotations);
  return make_single_segment(
      request, SplineCurve{numerics::CubicSpline(std::move(knots), std::move(values), numerics::SplineEnd::natural)},
      std::move(rotation));
}

/// Values of the law at the waypoints: given fractions are times, but the spline's knots are values of the law.
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

SegmentedPath make_path(const Request& request, const WaypointPath& path) {
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

/// Times as fractions of the table's duration, so that a uniform law traverses it like any other curve.
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
                                  format_value_count(static_cast<Eigen::Index>(columns)) + ", all finite; it has " +
                                  format_value_count(static_cast<Eigen::Index>(row.size())));
    }
    for (std::size_t c = 0; c < columns; ++c)
      values(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(c)) = row[c];
  }
  return values;
}

SegmentedPath make_path(const Request& request, const TablePath& path) {
  const std::vector<double> knots = table_knots(path);
  const Samples rows = table_values(path);
  const Eigen::Index size = rows.cols() - (request.has_rotation ? 3 : 0);
  const Eigen::Index expected_size = request.from.value.size();
  if (size < 0 || rows.cols() == 0 || (expected_size != 0 && expected_size != size)) {
    throw std::invalid_argument("the motion's table has " + format_value_count(rows.cols()) +
                                " per row, but the drive has " +
                                format_value_count(expected_size + (request.has_rotation ? 3 : 0)));
  }
  SegmentedPath result{
      .duration = path.time.back() - path.time.front(), .size = static_cast<int>(size), .segments = {}};
  RotationCurve rotation = NoRotation{};
  if (request.has_rotation) rotation = interpolate_rotation_vectors(knots, rows.rightCols(3));
  const TimeScaling time_scaling({.kind = MotionLawKind::uniform}, 0, result.duration,
                                 time_tolerance * result.duration);
  result.segments.push_back(
      {time_scaling, SplineCurve{numerics::CubicSpline(knots, rows.leftCols(size), numerics::SplineEnd::not_a_knot)},
       std::move(rotation)});
  return result;
}

}  // namespace

SegmentedPath make_segmented_path(const PrescribedMotion::Request& request) {
  return std::visit([&](const auto& path) { return make_path(request, path); }, request.path);
}

namespace {

/// Waypoints closer in time than this fraction of the duration are an error.
constexpr double min_fraction_gap = 1e-9;

std::string format_decimal(double value) {
  std::string text = std::to_string(value);
  text.erase(text.find_last_not_of('0') + 1);
  return text.back() == '.' ? text + "0" : text;
}

std::string name_waypoint(std::size_t point, std::size_t points) {
  if (point == 0) return "the start";
  if (point + 1 == points) return "the end";
  return "waypoint " + std::to_string(point);
}

std::vector<double> complete_fractions(const std::vector<double>& fractions, std::size_t waypoints) {
  if (fractions.size() != waypoints) {
    throw std::invalid_argument("there must be one fraction per waypoint: " + std::to_string(waypoints) +
                                " waypoints, " + std::to_string(fractions.size()) + " fractions");
  }
  std::vector<double> completed{0};
  completed.insert(completed.end(), fractions.begin(), fractions.end());
  completed.push_back(1);
  for (std::size_t i = 1; i < completed.size(); ++i) {
    if (completed[i] - completed[i - 1] > min_fraction_gap) continue;
    const std::string problem = i + 1 == completed.size()
                                    ? format_decimal(completed[i - 1]) + " is the last"
                                    : format_decimal(completed[i]) + " follows " + format_decimal(completed[i - 1]);
    throw std::invalid_argument("the fractions of waypoints must increase and lie between 0 and 1; " + problem);
  }
  return completed;
}

/// Chord lengths by the first measure that detects motion: position, all scalars, rotation.
std::vector<double> compute_chord_lengths(const std::vector<DriveValue>& points, int position_components,
                                          bool has_rotation) {
  const auto measure_lengths = [&](auto distance) {
    std::vector<double> lengths;
    for (std::size_t i = 1; i < points.size(); ++i) lengths.push_back(distance(points[i - 1], points[i]));
    return lengths;
  };
  const auto has_motion = [](const std::vector<double>& lengths) {
    return std::any_of(lengths.begin(), lengths.end(), [](double length) { return length > 0; });
  };
  std::vector<double> lengths = measure_lengths([&](const DriveValue& a, const DriveValue& b) {
    return (b.value.head(position_components) - a.value.head(position_components)).norm();
  });
  if (has_motion(lengths)) return lengths;
  lengths = measure_lengths([](const DriveValue& a, const DriveValue& b) { return (b.value - a.value).norm(); });
  if (has_motion(lengths) || !has_rotation) return lengths;
  return measure_lengths([](const DriveValue& a, const DriveValue& b) {
    return rotation_vector_of(b.rotation * a.rotation.transpose()).norm();
  });
}

}  // namespace

std::vector<double> compute_waypoint_fractions(const std::vector<DriveValue>& points,
                                               const std::vector<double>& fractions, int position_components,
                                               bool has_rotation) {
  if (!fractions.empty()) return complete_fractions(fractions, points.size() - 2);
  const std::vector<double> lengths = compute_chord_lengths(points, position_components, has_rotation);
  double total = 0;
  for (const double length : lengths) total += length;
  std::vector<double> fractions_of_duration{0};
  double travelled = 0;
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    if (!(lengths[i] > min_fraction_gap * total)) {
      throw std::invalid_argument(name_waypoint(i, points.size()) + " and " + name_waypoint(i + 1, points.size()) +
                                  " coincide, so the distances between the points do not determine their times: state "
                                  "the waypoints' fractions of the duration");
    }
    travelled += lengths[i];
    fractions_of_duration.push_back(travelled / total);
  }
  fractions_of_duration.back() = 1;
  return fractions_of_duration;
}

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
  // Power series in x = θ² where the closed forms suffer from cancellation: a = Σ (−x)ⁿ/(2n+2)!, b = Σ (−x)ⁿ/(2n+3)!,
  // a'/θ = 2 da/dx. After eight terms the remainder is below 1e-17 for x ≤ 1/4.
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

/// The rotation vector of the rotation exp(vector) that is nearest to `reference`.
Vector3 find_nearest_rotation_vector(const Vector3& vector, const Vector3& reference) {
  const double angle = vector.norm();
  if (angle < 1e-12) {  // no axis: whole turns about the axis of `reference`
    const double full_turns = std::round(reference.norm() / two_pi);
    return full_turns == 0 ? vector : Vector3(vector + full_turns * two_pi * reference.normalized());
  }
  const Vector3 axis = vector / angle;
  return vector + two_pi * std::round((reference.dot(axis) - angle) / two_pi) * axis;
}

Vector3 row(const Samples& vectors, std::size_t i) { return vectors.row(static_cast<Eigen::Index>(i)).transpose(); }

/// Rotation vectors far from zero change much faster than their rotations, and a spline through them would oscillate.
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
  // Relative to the middle one the vectors are shortest, and the curve does not depend on the direction of travel.
  const std::size_t middle = rotations.size() / 2;
  const Matrix3& reference = rotations[middle];
  Samples vectors(static_cast<Eigen::Index>(rotations.size()), 3);
  const auto vector_of = [&](std::size_t i) { return rotation_vector_of(rotations[i] * reference.transpose()); };
  const auto set_row = [&](std::size_t i, const Vector3& neighbour) {
    vectors.row(static_cast<Eigen::Index>(i)) = find_nearest_rotation_vector(vector_of(i), neighbour).transpose();
  };
  set_row(middle, Vector3::Zero());
  for (std::size_t i = middle + 1; i < rotations.size(); ++i) set_row(i, row(vectors, i - 1));
  for (std::size_t i = middle; i-- > 0;) set_row(i, row(vectors, i + 1));
  for (std::size_t i = 1; i < rotations.size(); ++i) {
    require_close_rotations(row(vectors, i - 1), row(vectors, i), rotations[i - 1], rotations[i], i);
  }
  return {reference, numerics::CubicSpline(knots, std::move(vectors), numerics::SplineEnd::natural)};
}

SplineRotation interpolate_rotation_vectors(const std::vector<double>& knots, Samples vectors) {
  for (Eigen::Index i = 1; i < vectors.rows(); ++i) {
    const Vector3 previous = vectors.row(i - 1).transpose(), current = vectors.row(i).transpose();
    vectors.row(i) = find_nearest_rotation_vector(current, previous).transpose();
  }
  return {Matrix3::Identity(), numerics::CubicSpline(knots, std::move(vectors), numerics::SplineEnd::not_a_knot)};
}

}  // namespace balance::trajectory
