#pragma once
/// All numbers of a mechanism and of a trajectory one after the other, to compare what two specs say.

#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <cmath>
#include <string>
#include <vector>

namespace specs {

class Numbers {
 public:
  Numbers& operator<<(double value) {
    all.push_back(value);
    return *this;
  }
  template <class Derived>
  Numbers& operator<<(const Eigen::MatrixBase<Derived>& values) {
    for (Eigen::Index i = 0; i < values.rows(); ++i)
      for (Eigen::Index j = 0; j < values.cols(); ++j) all.push_back(values(i, j));
    return *this;
  }
  template <class T>
  Numbers& operator<<(const std::vector<T>& values) {
    *this << static_cast<double>(values.size());
    for (const T& value : values) *this << value;
    return *this;
  }
  template <class T>
  Numbers& operator<<(const std::optional<T>& value) {
    *this << (value ? 1.0 : 0.0);
    return value ? *this << *value : *this;
  }
  Numbers& operator<<(const balance::CoordinateValue& value) { return *this << value.coordinate << value.value; }
  Numbers& operator<<(const balance::model::CoordinateTerm& term) { return *this << term.coordinate << term.ratio; }
  Numbers& operator<<(const balance::model::NamedPoint& point) { return *this << point.position; }

  std::vector<double> all;
};

inline std::vector<double> numbers_of(const balance::Mechanism& m) {
  Numbers n;
  n << m.gravity << m.assembly << m.actuators;
  for (const auto& b : m.bodies) n << b.mass << b.com << b.inertia << b.points;
  for (const auto& j : m.joints)
    n << j.first << j.second << j.point_first << j.point_second << j.axis << j.axis2 << j.rotation;
  for (const auto& c : m.couplings) n << c.follower << c.leader.terms << c.ratio << c.offset;
  for (const auto& a : m.attachments) n << a.body << a.position << a.mass << a.inertia;
  for (const auto& d : m.discs)
    n << d.body << d.follows.terms << d.position << d.axis << d.ratio << d.mass << d.inertia;
  for (const auto& l : m.loads) n << l.body << l.point << l.arguments << l.force << l.moment;
  for (const auto& s : m.springs)
    n << s.first << s.second << s.point_first << s.point_second << s.stiffness << s.free_length;
  for (const auto& e : m.force_elements)
    n << e.first << e.second << e.point_first << e.point_second << e.coordinate << e.damping << e.table.displacement
      << e.table.force;
  for (const auto& f : m.friction)
    n << f.coordinate << f.viscous << f.dry_friction(1) << f.dry_friction(-1) << f.static_limit(1)
      << f.static_limit(-1);
  if (m.tool) n << m.tool->body << m.tool->position;
  return n.all;
}

inline void add_pose(Numbers& n, const balance::trajectory::PoseTarget& pose) {
  n << pose.joints << pose.tool << pose.angle << pose.orientation << pose.com;
}

inline std::vector<double> numbers_of(const balance::Trajectory& t) {
  Numbers n;
  n << t.duration << static_cast<double>(t.samples) << t.about << t.remaining_coordinates << t.law.ramp_up
    << t.law.ramp_down;
  add_pose(n, t.from);
  add_pose(n, t.to);
  n << static_cast<double>(t.path.index());
  if (const auto* circle = std::get_if<balance::trajectory::CirclePath>(&t.path))
    n << circle->centre << circle->normal << circle->angle;
  if (const auto* arc = std::get_if<balance::trajectory::ArcPath>(&t.path)) n << arc->via;
  if (const auto* table = std::get_if<balance::trajectory::TablePath>(&t.path)) n << table->time << table->values;
  if (const auto* way = std::get_if<balance::trajectory::WaypointPath>(&t.path)) {
    n << way->fractions;
    for (const auto& point : way->points) add_pose(n, point);
  }
  return n.all;
}

inline std::vector<double> numbers_of(const std::vector<balance::Trajectory>& all) {
  Numbers n;
  for (const auto& trajectory : all) n << numbers_of(trajectory);
  return n.all;
}

/// The largest difference relative to the numbers themselves; infinite if they are not equally many.
inline double difference(const std::vector<double>& a, const std::vector<double>& b) {
  if (a.size() != b.size()) return INFINITY;
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (a[i] != b[i]) largest = std::max(largest, std::abs(a[i] - b[i]) / std::max(std::abs(a[i]), std::abs(b[i])));
  return largest;
}

}  // namespace specs
