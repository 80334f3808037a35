#pragma once
/// Conversion of trajectories to another scalar type.

#include "balance/mechanics/trajectory/trajectory.hpp"

namespace balance::trajectory {

/// Applies `number` (From → To) to every number of a trajectory and copies everything else.
template <class To, class From, class Function>
class TrajectoryConversion {
 public:
  explicit TrajectoryConversion(const Function& number) : number_(number) {}

  TrajectoryOf<To> operator()(const TrajectoryOf<From>& from) const {
    TrajectoryOf<To> to;
    to.name = from.name;
    to.law = convert(from.law);
    for (const auto& limit : from.limits)
      to.limits.push_back({limit.quantity, number_(limit.upper_bound), convert(limit.lower_bound)});
    to.min_peak_quantity = from.min_peak_quantity;
    to.start_speed = number_(from.start_speed), to.end_speed = number_(from.end_speed);
    to.drive = from.drive;
    to.components = from.components;
    to.remaining_coordinates = from.remaining_coordinates;
    to.remaining_angle = from.remaining_angle;
    for (const auto& task : from.secondary_tasks)
      std::visit([&](const auto& kind) { to.secondary_tasks.push_back({task.coordinate, convert(kind)}); }, task.kind);
    std::visit([&](const auto& path) { to.path = convert(path); }, from.path);
    if (const auto& c = from.corridor)
      to.corridor = CorridorOf<To>{number_(c->width), c->inner_knots, c->starts, c->control_points};
    to.from = convert(from.from);
    to.to = convert(from.to);
    to.duration = number_(from.duration);
    to.samples = from.samples;
    to.about = convert(from.about);
    for (const auto& adaptation : from.adaptations) {
      to.adaptations.push_back({adaptation.attachment, {}});
      for (const auto& move : adaptation.moves)
        to.adaptations.back().moves.push_back({convert(move.to), move.start, move.duration, convert(move.law)});
    }
    to.courses = from.courses;
    if (const auto& m = from.free_motion)
      to.free_motion = FreeMotionOf<To>{m->free, m->held, m->start, convert(m->rate)};
    return to;
  }

 private:
  MotionLawOf<To> convert(const MotionLawOf<From>& law) const {
    return {law.kind, number_(law.ramp_up), number_(law.ramp_down), law.nodes};
  }
  SplineTaskOf<To> convert(const SplineTaskOf<From>& spline) const {
    return {convert(spline.coefficients), spline.has_middle_jump, spline.over_time};
  }
  MomentumTaskOf<To> convert(const MomentumTaskOf<From>& momentum) const {
    return {momentum.axis, convert(momentum.time), convert(momentum.value), momentum.solution, momentum.over_time};
  }
  std::optional<To> convert(const std::optional<From>& value) const {
    return value ? std::optional<To>(number_(*value)) : std::nullopt;
  }
  Vector3Of<To> convert(const Vector3Of<From>& v) const { return {number_(v[0]), number_(v[1]), number_(v[2])}; }
  Matrix3Of<To> convert(const Matrix3Of<From>& m) const {
    Matrix3Of<To> to;
    for (int column = 0; column < 3; ++column) to.col(column) = convert(Vector3Of<From>(m.col(column)));
    return to;
  }
  std::vector<To> convert(const std::vector<From>& list) const {
    std::vector<To> to;
    to.reserve(list.size());
    for (const From& value : list) to.push_back(number_(value));
    return to;
  }
  std::vector<model::CoordinateValueOf<To>> convert(const std::vector<model::CoordinateValueOf<From>>& list) const {
    std::vector<model::CoordinateValueOf<To>> to;
    for (const auto& entry : list) to.push_back({entry.coordinate, number_(entry.value)});
    return to;
  }
  PoseTargetOf<To> convert(const PoseTargetOf<From>& from) const {
    PoseTargetOf<To> to;
    to.joints = convert(from.joints);
    if (from.tool) to.tool = convert(*from.tool);
    if (from.angle) to.angle = number_(*from.angle);
    if (from.orientation) to.orientation = convert(*from.orientation);
    if (from.com) to.com = convert(*from.com);
    return to;
  }
  LinePath convert(const LinePath& from) const { return from; }
  CirclePathOf<To> convert(const CirclePathOf<From>& from) const {
    return {convert(from.centre), convert(from.normal), number_(from.angle)};
  }
  ArcPathOf<To> convert(const ArcPathOf<From>& from) const { return {convert(from.via)}; }
  WaypointPathOf<To> convert(const WaypointPathOf<From>& from) const {
    WaypointPathOf<To> to{{}, from.spline, convert(from.fractions)};
    for (const auto& point : from.points) to.points.push_back(convert(point));
    return to;
  }
  TablePathOf<To> convert(const TablePathOf<From>& from) const {
    TablePathOf<To> to{convert(from.time), {}};
    to.values.reserve(from.values.size());
    for (const auto& row : from.values) to.values.push_back(convert(row));
    return to;
  }

  const Function& number_;
};

/// Applies `number` (From → To) to every number of `from` and copies everything else.
template <class To, class From, class Function>
TrajectoryOf<To> cast_scalar(const TrajectoryOf<From>& from, const Function& number) {
  return TrajectoryConversion<To, From, Function>(number)(from);
}

}  // namespace balance::trajectory
