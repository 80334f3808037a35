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

using Request = Schedule::Request;

std::string count(Eigen::Index n) { return std::to_string(n) + (n == 1 ? " value" : " values"); }

void require_values(const Request& request, const DriveValue& given, const std::string& name) {
  if (given.value.size() != request.from.value.size()) {
    throw std::invalid_argument("the motion starts with " + count(request.from.value.size()) + ", but " + name +
                                " has " + count(given.value.size()));
  }
  if (!given.value.allFinite()) throw std::invalid_argument(name + " of the motion must be finite numbers");
  if (!request.turns) return;
  const Matrix3 error = given.rotation * given.rotation.transpose() - Matrix3::Identity();
  // NaN fails as well; the bound admits rotations that were typed with some six digits
  if (!(error.norm() < 1e-5) || !(given.rotation.determinant() > 0)) {
    throw std::invalid_argument("the orientation at " + name + " of the motion is not a rotation");
  }
}

void require_common(const Request& request) {
  if (!(request.duration > 0) || !std::isfinite(request.duration)) {
    throw std::invalid_argument("the duration of a motion must be positive, is " + std::to_string(request.duration) +
                                " s");
  }
  validate(request.law);
  require_values(request, request.from, "the start");
  if (request.from.value.size() == 0 && !request.turns) throw std::invalid_argument("the motion prescribes nothing");
  if (request.position_components < 0 ||
      request.position_components > std::min<Eigen::Index>(3, request.from.value.size())) {
    throw std::invalid_argument("a motion of " + count(request.from.value.size()) + " cannot lead with the " +
                                std::to_string(request.position_components) + " coordinates of a point");
  }
}

StraightCurve straight(const DriveValue& from, const DriveValue& to) { return {from.value, to.value - from.value}; }

Turn turn_between(const Request& request, const DriveValue& from, const DriveValue& to) {
  if (!request.turns) return NoTurn{};
  return shortest_turn(from.rotation, to.rotation);
}

Clock whole(const Request& request) { return {request.law, 0, request.duration, same_time * request.duration}; }

Itinerary one_leg(const Request& request, Curve curve, Turn turn) {
  Itinerary result{.duration = request.duration, .size = static_cast<int>(request.from.value.size()), .legs = {}};
  result.legs.push_back({whole(request), std::move(curve), std::move(turn)});
  return result;
}

Itinerary make_itinerary(const Request& request, const LinePath&) {
  require_common(request);
  require_values(request, request.to, "the end");
  return one_leg(request, straight(request.from, request.to), turn_between(request, request.from, request.to));
}

Itinerary make_itinerary(const Request& request, const ArcPath& path) {
  require_common(request);
  require_values(request, request.to, "the end");
  return one_leg(request, arc(straight(request.from, request.to), request.position_components, path),
                 turn_between(request, request.from, request.to));
}

Itinerary make_itinerary(const Request& request, const CirclePath& path) {
  require_common(request);
  const bool stays = request.to.value.size() == 0;  // nothing but the point moves
  if (!stays) require_values(request, request.to, "the end");
  const DriveValue& to = stays ? request.from : request.to;
  return one_leg(request, circle(straight(request.from, to), request.position_components, path),
                 turn_between(request, request.from, to));
}

Itinerary stop_at_each(const Request& request, const std::vector<DriveValue>& points,
                       const std::vector<double>& fractions) {
  Itinerary result{.duration = request.duration, .size = static_cast<int>(request.from.value.size()), .legs = {}};
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double start = fractions[i - 1] * request.duration;
    const Clock clock(request.law, start, fractions[i] * request.duration - start, same_time * request.duration);
    result.legs.push_back({clock, straight(points[i - 1], points[i]), turn_between(request, points[i - 1], points[i])});
  }
  return result;
}

/// The ends are natural, not clamped: the law already brings the motion to rest, so a curve whose own slope vanished
/// there would only crowd the motion into the middle. Of all curves through the points the natural spline bends least.
Itinerary spline_through(const Request& request, const std::vector<DriveValue>& points, std::vector<double> knots) {
  Samples values(static_cast<Eigen::Index>(points.size()), request.from.value.size());
  std::vector<Matrix3> rotations;
  for (std::size_t i = 0; i < points.size(); ++i) {
    values.row(static_cast<Eigen::Index>(i)) = points[i].value.transpose();
    rotations.push_back(points[i].rotation);
  }
  Turn turn = NoTurn{};
  if (request.turns) turn = spline_turn(knots, rotations);
  return one_leg(request, SplineCurve{CubicSpline(std::move(knots), std::move(values), SplineEnd::natural)},
                 std::move(turn));
}

/// Where the law stands when the waypoints are due: stated fractions are times, the spline's knots are values of the
/// law.
std::vector<double> law_at(const Law& law, std::vector<double> fractions) {
  for (double& fraction : fractions) fraction = evaluate(law, fraction).s;
  for (std::size_t i = 1; i < fractions.size(); ++i) {
    if (fractions[i] - fractions[i - 1] > same_time) continue;
    throw std::invalid_argument("the law of motion hardly moves between the fractions of waypoints " +
                                std::to_string(i - 1) + " and " + std::to_string(i) +
                                " (0 is the start): a spline needs them further apart");
  }
  return fractions;
}

Itinerary make_itinerary(const Request& request, const WaypointPath& path) {
  require_common(request);
  require_values(request, request.to, "the end");
  if (request.via.empty()) throw std::invalid_argument("a path through waypoints needs at least one waypoint");
  std::vector<DriveValue> points{request.from};
  for (const DriveValue& point : request.via) {
    require_values(request, point, "waypoint " + std::to_string(points.size()));
    points.push_back(point);
  }
  points.push_back(request.to);
  const std::vector<double> fractions =
      passing_fractions(points, path.fractions, request.position_components, request.turns);
  if (!path.spline) return stop_at_each(request, points, fractions);
  return spline_through(request, points, path.fractions.empty() ? fractions : law_at(request.law, fractions));
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
                                  count(static_cast<Eigen::Index>(columns)) + ", finite numbers; it has " +
                                  count(static_cast<Eigen::Index>(row.size())));
    }
    for (std::size_t c = 0; c < columns; ++c)
      values(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(c)) = row[c];
  }
  return values;
}

Itinerary make_itinerary(const Request& request, const TablePath& path) {
  const std::vector<double> knots = table_knots(path);
  const Samples all = table_values(path);
  const Eigen::Index size = all.cols() - (request.turns ? 3 : 0);
  const Eigen::Index asked = request.from.value.size();
  if (size < 0 || all.cols() == 0 || (asked != 0 && asked != size)) {
    throw std::invalid_argument("the motion's table has " + count(all.cols()) + " in a row, but the drive has " +
                                count(asked + (request.turns ? 3 : 0)));
  }
  Itinerary result{.duration = path.time.back() - path.time.front(), .size = static_cast<int>(size), .legs = {}};
  Turn turn = NoTurn{};
  if (request.turns) turn = table_turn(knots, all.rightCols(3));
  const Clock clock({.kind = LawKind::uniform}, 0, result.duration, same_time * result.duration);
  result.legs.push_back(
      {clock, SplineCurve{CubicSpline(knots, all.leftCols(size), SplineEnd::not_a_knot)}, std::move(turn)});
  return result;
}

}  // namespace

Itinerary make_itinerary(const Schedule::Request& request) {
  return std::visit([&](const auto& path) { return make_itinerary(request, path); }, request.path);
}

}  // namespace balance
