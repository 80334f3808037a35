#include "balance/interface/reports/mechanism_drawing.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/rotation.hpp"
#include "balance/interface/reports/html_report_data.hpp"
#include "balance/mechanics/results/body_poses.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <utility>

namespace balance::reports {
namespace {

// Sizes of symbols in units of the drawing scale.
constexpr double joint_radius = 0.85, tool_radius = 0.45, spring_end_radius = 0.4;
constexpr double bearing_height = 3, bearing_half_width = 1.9, hatch_depth = 1.1;
constexpr double block_half_length = 2.2, block_half_width = 1.3, guide_overhang = 4;
constexpr double axis_half_length = 2.2, spring_half_width = 1;
constexpr double max_rotor_radius =
    0.15;  // in characteristic lengths: a link of an arm may have the inertia of a large disc
constexpr int circle_points = 36, spring_turns = 8;
constexpr double units_across = 100;  // of the larger side of a picture

constexpr double coincidence_tolerance = 1e-6;  // of the unit; nearer points are one

double distance(const PlotPoint& a, const PlotPoint& b) { return std::hypot(a.x - b.x, a.y - b.y); }

/// Points of a circle about the origin of a plane.
std::vector<Vector3> circle(double radius) {
  std::vector<Vector3> points;
  for (int i = 0; i < circle_points; ++i) {
    const auto angle = sine_cosine(2 * std::numbers::pi * i / circle_points);
    points.emplace_back(radius * angle.cosine, radius * angle.sine, 0);
  }
  return points;
}

PlotPoint between(const PlotPoint& a, const PlotPoint& b, double fraction) {
  return {a.x + fraction * (b.x - a.x), a.y + fraction * (b.y - a.y)};
}

}  // namespace

const std::vector<std::string>& list_projections() {
  static const std::vector<std::string> names = {"xy", "xz", "yz", "isometric"};
  return names;
}

Projection projection_by_name(const std::string& name) {
  const Vector3 x = Vector3::UnitX(), y = Vector3::UnitY(), z = Vector3::UnitZ();
  if (name == "xy") return {x, y, "x", "y", false};
  if (name == "xz") return {x, z, "x", "z", true};
  if (name == "yz") return {y, z, "y", "z", true};
  if (name == "isometric")
    return {(y - x) / std::numbers::sqrt2, (2 * z - x - y) / std::sqrt(6.0), "isometric view, (y − x)/√2",
            "(2z − x − y)/√6", true};
  throw std::invalid_argument("no projection " + name);
}

namespace {

/// World frames of all bodies at one sample.
class BodyFrames {
 public:
  BodyFrames(const Mechanism& mechanism, const RunResult& result, Eigen::Index row)
      : poses_(body_poses(mechanism, extract_rows(result, {row}))) {}

  Vector3 point(BodyId body, const Vector3& local) const { return origin(body) + direction(body, local); }

  Vector3 direction(BodyId body, const Vector3& local) const {
    const auto q = poses_.orientation.row(0).segment<4>(4 * static_cast<Eigen::Index>(body));
    return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix() * local;
  }

 private:
  Vector3 origin(BodyId body) const {
    return poses_.position.row(0).segment<3>(3 * static_cast<Eigen::Index>(body)).transpose();
  }

  results::BodyPoses poses_;
};

bool slides(JointType type) {
  return type == JointType::prismatic || type == JointType::pin_slot || type == JointType::cylindrical;
}

/// Index of a joint's slide among all coordinates. @param joint one that slides
Eigen::Index slide_column(const Mechanism& mechanism, std::size_t joint) {
  for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c)
    if (static_cast<std::size_t>(mechanism.coordinates[c].joint) == joint &&
        mechanism.coordinates[c].kind == CoordinateKind::length)
      return static_cast<Eigen::Index>(c);
  throw std::invalid_argument("a joint without a slide");
}

struct Travel {
  double low = 0, high = 0;  ///< [m]
};

Travel travel_of(const Mechanism& mechanism, const RunResult& result, std::size_t joint) {
  const auto column = result.joint_position.col(slide_column(mechanism, joint));
  Travel travel{column[0], column[0]};
  for (const double slide : column) travel = {std::min(travel.low, slide), std::max(travel.high, slide)};
  return travel;
}

/// Radius of a wheel that rolls along a pin-slot joint: how far it slides for a turn by one radian; 0 if it does not.
double rolling_radius(const Mechanism& mechanism, std::size_t joint) {
  if (mechanism.joints[joint].type != JointType::pin_slot) return 0;
  const Eigen::Index slide = slide_column(mechanism, joint);
  for (const Coupling& coupling : mechanism.couplings) {
    if (static_cast<Eigen::Index>(coupling.follower) != slide || coupling.offset != 0) continue;
    const auto& terms = coupling.leader.terms;
    if (terms.size() != 1 || static_cast<Eigen::Index>(terms[0].coordinate) != slide + 1) continue;
    return std::max(-coupling.ratio * terms[0].ratio, 0.0);
  }
  return 0;
}

/// Whether all points are one.
bool are_coincident(const std::vector<Vector3>& points, const Mechanism& mechanism) {
  const double tolerance = coincidence_tolerance * characteristic_length(mechanism);
  return std::all_of(points.begin(), points.end(),
                     [&](const Vector3& p) { return (p - points[0]).norm() < tolerance; });
}

/// Radius of the solid disc with this mass and moment of inertia about its axis; 0 without either.
double solid_disc_radius(double mass, double axial_inertia) {
  return mass > 0 && axial_inertia > 0 ? std::sqrt(2 * axial_inertia / mass) : 0;
}

/// Points of a body that make its outline: named ones, those of its joints and the tool. A body with a single one also
/// has its centre of mass.
std::vector<Vector3> outline_points(const Mechanism& mechanism, BodyId body) {
  std::vector<Vector3> points;
  const Body& own = mechanism.bodies[static_cast<std::size_t>(body)];
  for (const model::NamedPoint& point : own.points) points.push_back(point.position);
  for (const Joint& joint : mechanism.joints) {
    if (joint.first == body && !slides(joint.type)) points.push_back(joint.point_first);
    if (joint.second == body) points.push_back(joint.point_second);
  }
  if (mechanism.tool && mechanism.tool->body == body) points.push_back(mechanism.tool->position);
  if (!points.empty() && are_coincident(points, mechanism)) points.push_back(own.com);
  return points;
}

/// A body whose points are all one is a rotor: a solid disc of its mass and inertia about the axis through them.
struct Rotor {
  Vector3 centre, axis;  ///< in the body's axes
  double radius = 0;     ///< [m]; 0: it is none
};

Rotor rotor_of(const Mechanism& mechanism, BodyId body) {
  const Body& own = mechanism.bodies[static_cast<std::size_t>(body)];
  const std::vector<Vector3> points = outline_points(mechanism, body);
  if (points.empty() || !are_coincident(points, mechanism) || own.mass <= 0) return {};
  Vector3 axis = Vector3::UnitZ();
  for (const Joint& joint : mechanism.joints)
    if (joint.type == JointType::revolute && joint.second == body) axis = joint.rotation.transpose() * joint.axis;
  const double solid = solid_disc_radius(own.mass, axis.dot(own.inertia * axis));
  return {points[0], axis, std::min(solid, max_rotor_radius * characteristic_length(mechanism))};
}

/// Convex hull, counter-clockwise (Andrew's monotone chain); both ends of a line if all points are on one.
std::vector<PlotPoint> convex_hull(std::vector<PlotPoint> points, double near) {
  std::sort(points.begin(), points.end(),
            [](const PlotPoint& a, const PlotPoint& b) { return a.x < b.x || (a.x == b.x && a.y < b.y); });
  const auto turn = [](const PlotPoint& o, const PlotPoint& a, const PlotPoint& b) {
    return (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x);
  };
  const auto half = [&](auto begin, auto end) {
    std::vector<PlotPoint> chain;
    for (auto p = begin; p != end; ++p) {
      while (chain.size() > 1 &&
             turn(chain[chain.size() - 2], chain.back(), *p) <= near * distance(chain[chain.size() - 2], *p))
        chain.pop_back();
      chain.push_back(*p);
    }
    chain.pop_back();
    return chain;
  };
  if (points.size() < 3) return points;
  std::vector<PlotPoint> hull = half(points.begin(), points.end());
  for (const PlotPoint& p : half(points.rbegin(), points.rend())) hull.push_back(p);
  return hull;
}

/// Draws the parts of one mechanism in one pose.
class PoseDrawer {
 public:
  PoseDrawer(const Mechanism& mechanism, const RunResult& result, Eigen::Index row, const Projection& projection,
             const DrawingScale& scale)
      : mechanism_(mechanism),
        result_(result),
        row_(row),
        projection_(projection),
        scale_(scale),
        frames_(mechanism, result, row) {}

  std::vector<Outline> outlines() {
    for (std::size_t body = 1; body < mechanism_.bodies.size(); ++body) draw_link(static_cast<int>(body));
    for (std::size_t joint = 0; joint < mechanism_.joints.size(); ++joint) draw_joint(joint);
    for (const Attachment& attachment : mechanism_.attachments) draw_attachment(attachment);
    for (const Disc& disc : mechanism_.discs) draw_disc(disc);
    for (const Spring& spring : mechanism_.springs)
      if (!spring.is_joint_spring()) draw_spring(spring);
    if (mechanism_.tool)
      add_circle(DrawingPart::tool, at(mechanism_.tool->body, mechanism_.tool->position), tool_radius);
    std::stable_sort(outlines_.begin(), outlines_.end(),
                     [](const Outline& a, const Outline& b) { return a.part < b.part; });
    return std::move(outlines_);
  }

 private:
  PlotPoint at(BodyId body, const Vector3& local) const { return projection_.apply(frames_.point(body, local)); }

  void add(DrawingPart part, bool is_closed, std::vector<PlotPoint> points) {
    outlines_.push_back({part, is_closed, std::move(points)});
  }

  /// @param radius in units
  void add_circle(DrawingPart part, const PlotPoint& centre, double radius) {
    std::vector<PlotPoint> points;
    for (const Vector3& p : circle(radius * scale_.unit)) points.push_back({centre.x + p.x(), centre.y + p.y()});
    add(part, true, std::move(points));
  }

  /// A circle in space. @param axis its normal, world axes @param radius [m]
  void add_rim(DrawingPart part, const Vector3& centre, const Vector3& axis, double radius) {
    const Matrix3 frame = frame_with_z_along(axis);
    std::vector<PlotPoint> points;
    for (const Vector3& p : circle(radius)) points.push_back(projection_.apply(centre + frame * p));
    add(part, true, std::move(points));
  }

  void draw_link(BodyId body) {
    if (const Rotor rotor = rotor_of(mechanism_, body); rotor.radius > 0) {
      const Vector3 spoke = frame_with_z_along(rotor.axis) * (rotor.radius * Vector3::UnitX());
      add_rim(DrawingPart::disc, frames_.point(body, rotor.centre), frames_.direction(body, rotor.axis), rotor.radius);
      add(DrawingPart::disc, false, {at(body, rotor.centre), at(body, rotor.centre + spoke)});
      return;
    }
    std::vector<PlotPoint> points;
    for (const Vector3& point : outline_points(mechanism_, body)) points.push_back(at(body, point));
    if (points.empty()) return;
    const double near = coincidence_tolerance * scale_.unit;
    points = convex_hull(std::move(points), near);
    const bool is_area = points.size() > 2;
    if (points.size() < 2 || (!is_area && distance(points[0], points[1]) < near)) return;
    add(DrawingPart::link, is_area, std::move(points));
  }

  void draw_joint(std::size_t index) {
    const Joint& joint = mechanism_.joints[index];
    const Vector3 place = frames_.point(joint.second, joint.point_second);
    if (joint.type == JointType::fixed) return;
    if (is_rolling(joint.type)) return draw_rolling(joint, place);
    if (const double radius = rolling_radius(mechanism_, index); radius > 0) {
      add_rim(DrawingPart::disc, place, Vector3::UnitZ(), radius);
      const Vector3 spoke(radius, 0, 0);
      add(DrawingPart::disc, false, {projection_.apply(place), at(joint.second, joint.point_second + spoke)});
    } else if (slides(joint.type)) {
      draw_slide(index, place);
    }
    if (joint.type == JointType::planar) return draw_block(joint, frames_.direction(joint.first, joint.axis2), place);
    if (joint.type == JointType::prismatic) return;
    if (joint.type == JointType::revolute) draw_axis(frames_.direction(joint.first, joint.axis), place);
    add_circle(DrawingPart::joint, projection_.apply(place), joint_radius);
  }

  /// A revolute joint's axis, unless it points to the viewer.
  void draw_axis(const Vector3& axis, const Vector3& place) {
    const Vector3 half = axis_half_length * scale_.unit * axis;
    const PlotPoint begin = projection_.apply(place - half), end = projection_.apply(place + half);
    if (distance(begin, end) > 2 * joint_radius * scale_.unit) add(DrawingPart::axis, false, {begin, end});
  }

  void draw_rolling(const Joint& joint, const Vector3& centre) {
    if (joint.type == JointType::rolling_sphere) {
      add_rim(DrawingPart::disc, centre, projection_.towards_viewer(), joint.radius);
    } else {
      const Vector3 spin = frames_.direction(joint.second, joint.rotation.transpose() * joint.axis.cross(joint.axis2));
      add_rim(DrawingPart::disc, centre, spin, joint.radius);
    }
    const Vector3 rim_point = joint.radius * (joint.rotation.transpose() * joint.axis);
    add(DrawingPart::disc, false, {projection_.apply(centre), at(joint.second, joint.point_second + rim_point)});
  }

  /// The block, and the guide if it is part of a moving body.
  void draw_slide(std::size_t index, const Vector3& place) {
    const Joint& joint = mechanism_.joints[index];
    const Vector3 along = frames_.direction(joint.first, joint.axis);
    if (joint.first != model::ground) {
      const auto [begin, end] = rail_of(index);
      add(DrawingPart::link, false,
          {at(joint.first, joint.point_first + begin * joint.axis),
           at(joint.first, joint.point_first + end * joint.axis)});
    }
    draw_block(joint, along, place);
  }

  /// From and to which slide a moving body's rail is drawn: over the travel, or, of a telescope, which never closes, up
  /// to the block.
  std::pair<double, double> rail_of(std::size_t joint) const {
    const Travel travel = travel_of(mechanism_, result_, joint);
    const double room = guide_overhang * scale_.unit;
    if (travel.low < 2 * room && travel.high > -2 * room) return {travel.low - room, travel.high + room};
    return {0, result_.joint_position(row_, slide_column(mechanism_, joint))};
  }

  void draw_block(const Joint& joint, const Vector3& along, const Vector3& place) {
    const PlotPoint centre = projection_.apply(place), direction = projection_.apply(along);
    const double size = std::hypot(direction.x, direction.y), unit = scale_.unit;
    const bool is_seen = size > 0.2;  // else it slides to or from the viewer, as a square
    const PlotPoint u = is_seen ? PlotPoint{direction.x / size, direction.y / size} : PlotPoint{1, 0};
    const double half = (is_seen && joint.type != JointType::planar ? block_half_length : block_half_width) * unit,
                 side = block_half_width * unit;
    std::vector<PlotPoint> corners;
    for (const auto& [a, b] : {std::pair{-half, -side}, {half, -side}, {half, side}, {-half, side}})
      corners.push_back({centre.x + a * u.x - b * u.y, centre.y + a * u.y + b * u.x});
    add(DrawingPart::slider, true, std::move(corners));
  }

  void draw_attachment(const Attachment& attachment) {
    const double time = result_.time[row_];
    if (attachment.mass <= 0 || time < attachment.from || time >= attachment.until) return;
    const bool planar = mechanism_.space == SpaceKind::planar;
    const double share = attachment.mass / scale_.heaviest_mass;
    // areas of planar masses and volumes of spatial ones are proportional to them
    const double radius = planar ? 0.12 * std::sqrt(share) : 0.09 * std::cbrt(share);
    const double size = radius * characteristic_length(mechanism_) / scale_.unit;
    const PlotPoint place = at(attachment.body, attachment.position);
    draw_arm(attachment, place);
    if (attachment.kind == AttachmentKind::counterweight) return add_circle(DrawingPart::mass, place, size);
    const double half = 0.886 * size * scale_.unit;  // a square of the circle's area
    add(DrawingPart::mass, true,
        {{place.x - half, place.y - half},
         {place.x + half, place.y - half},
         {place.x + half, place.y + half},
         {place.x - half, place.y + half}});
  }

  /// A line to the nearest point of the body that carries a mass.
  void draw_arm(const Attachment& attachment, const PlotPoint& place) {
    std::optional<PlotPoint> nearest;
    for (const Vector3& point : outline_points(mechanism_, attachment.body)) {
      const PlotPoint candidate = at(attachment.body, point);
      if (!nearest || distance(candidate, place) < distance(*nearest, place)) nearest = candidate;
    }
    if (nearest && attachment.body != model::ground && distance(*nearest, place) > coincidence_tolerance * scale_.unit)
      add(DrawingPart::link, false, {*nearest, place});
  }

  void draw_disc(const Disc& disc) {
    const double length = characteristic_length(mechanism_);
    const double solid = solid_disc_radius(disc.mass, disc.axis.dot(disc.inertia * disc.axis));
    const double radius = std::clamp(solid, 0.06 * length, 0.35 * length);
    const Vector3 centre = frames_.point(disc.body, disc.position);
    const VectorX coordinates = result_.joint_position.row(row_).transpose();
    const auto angle = sine_cosine(disc.ratio * disc.follows.evaluate(coordinates));
    const Vector3 spoke = frame_with_z_along(disc.axis) * (radius * Vector3(angle.cosine, angle.sine, 0));
    add_rim(DrawingPart::disc, centre, frames_.direction(disc.body, disc.axis), radius);
    add(DrawingPart::disc, false, {projection_.apply(centre), at(disc.body, disc.position + spoke)});
  }

  /// A zigzag between both ends.
  void draw_spring(const Spring& spring) {
    const PlotPoint a = at(spring.first, spring.point_first), b = at(spring.second, spring.point_second);
    const double length = distance(a, b), width = spring_half_width * scale_.unit;
    if (length < scale_.unit) return;
    std::vector<PlotPoint> points = {a};
    for (int i = 0; i <= 2 * spring_turns; ++i) {
      const PlotPoint p = between(a, b, 0.12 + 0.76 * i / (2 * spring_turns));
      const double side = i == 0 || i == 2 * spring_turns ? 0 : i % 2 == 0 ? width : -width;
      points.push_back({p.x - side * (b.y - a.y) / length, p.y + side * (b.x - a.x) / length});
    }
    points.push_back(b);
    add(DrawingPart::spring, false, std::move(points));
    for (const PlotPoint& end : {a, b}) add_circle(DrawingPart::tool, end, spring_end_radius);
  }

  const Mechanism& mechanism_;
  const RunResult& result_;
  Eigen::Index row_;
  const Projection& projection_;
  const DrawingScale& scale_;
  BodyFrames frames_;
  std::vector<Outline> outlines_;
};

/// A line with hatching on the right-hand side as seen along it.
void add_hatched_line(const PlotPoint& from, const PlotPoint& to, double unit, std::vector<Outline>& outlines) {
  const double length = distance(from, to), depth = hatch_depth * unit;
  if (length < depth) return;
  const PlotPoint u{(to.x - from.x) / length, (to.y - from.y) / length};
  outlines.push_back({DrawingPart::ground, false, {from, to}});
  const int strokes = static_cast<int>(length / depth + 0.5 + 1e-9);
  for (int stroke = 0; stroke < strokes; ++stroke) {
    const double s = (stroke + 0.5) * depth;
    outlines.push_back(
        {DrawingPart::ground,
         false,
         {{from.x + s * u.x, from.y + s * u.y},
          {from.x + (s - 0.7 * depth) * u.x + depth * u.y, from.y + (s - 0.7 * depth) * u.y - depth * u.x}}});
  }
}

void add_bearing(const PlotPoint& at, double unit, std::vector<Outline>& outlines) {
  const double height = bearing_height * unit, half = bearing_half_width * unit;
  outlines.push_back({DrawingPart::ground, true, {at, {at.x - half, at.y - height}, {at.x + half, at.y - height}}});
  add_hatched_line({at.x - 1.5 * half, at.y - height}, {at.x + 1.5 * half, at.y - height}, unit, outlines);
}

/// The line under a slide or a wheel on the ground. @param below the side of the hatching, world axes [m]
void add_guide(const Joint& joint, const Travel& travel, double room, const Vector3& below,
               const Projection& projection, double unit, std::vector<Outline>& outlines) {
  const Vector3 begin = joint.point_first + (travel.low - room) * joint.axis + below;
  const Vector3 end = joint.point_first + (travel.high + room) * joint.axis + below;
  PlotPoint from = projection.apply(begin), to = projection.apply(end);
  if (from.x > to.x) std::swap(from, to);
  add_hatched_line(from, to, unit, outlines);
}

/// The plane that a body rolls on, where it is seen edge-on.
void add_floor(const Joint& joint, const Mechanism& mechanism, const RunResult& result, std::size_t first_coordinate,
               const Projection& projection, double unit, std::vector<Outline>& outlines) {
  if (std::abs(joint.axis.dot(projection.towards_viewer())) > 1e-6) return;
  const Vector3 along = joint.axis.cross(projection.towards_viewer());
  const Vector3 x = joint.axis2, y = joint.axis.cross(joint.axis2);
  double low = 0, high = 0;
  for (Eigen::Index k = 0; k < result.time.size(); ++k) {
    const auto column = static_cast<Eigen::Index>(first_coordinate);
    const double s = along.dot(result.joint_position(k, column) * x + result.joint_position(k, column + 1) * y);
    low = k == 0 ? s : std::min(low, s);
    high = k == 0 ? s : std::max(high, s);
  }
  const double room = std::max(joint.radius, 0.1 * characteristic_length(mechanism));
  PlotPoint from = projection.apply(joint.point_first + (low - room) * along),
            to = projection.apply(joint.point_first + (high + room) * along);
  if (from.x > to.x) std::swap(from, to);
  add_hatched_line(from, to, unit, outlines);
}

}  // namespace

std::vector<Outline> draw_ground(const Mechanism& mechanism, const RunResult& result, const Projection& projection,
                                 const DrawingScale& scale) {
  std::vector<Outline> outlines;
  std::vector<PlotPoint> bearings;
  std::size_t first_coordinate = 0;
  for (std::size_t j = 0; j < mechanism.joints.size(); ++j) {
    const Joint& joint = mechanism.joints[j];
    const std::size_t own_coordinate = first_coordinate;
    first_coordinate += static_cast<std::size_t>(joint_degrees_of_freedom(joint.type));
    if (joint.first != model::ground && joint.second != model::ground) continue;
    if (joint.first == model::ground && slides(joint.type)) {
      const double radius = rolling_radius(mechanism, j);
      const Vector3 across = Vector3::UnitZ().cross(joint.axis);
      const double gap = radius > 0 ? radius : block_half_width * scale.unit;
      // in space the guide is the joint's axis itself
      const Vector3 below = mechanism.space == SpaceKind::planar ? Vector3((joint.axis.x() < 0 ? gap : -gap) * across)
                                                                 : Vector3(Vector3::Zero());
      add_guide(joint, travel_of(mechanism, result, j), std::max(radius, guide_overhang * scale.unit), below,
                projection, scale.unit, outlines);
    } else if (is_rolling(joint.type)) {
      add_floor(joint, mechanism, result, own_coordinate, projection, scale.unit, outlines);
    } else if (mechanism.space != SpaceKind::planar || joint.type != JointType::planar) {
      const PlotPoint place = projection.apply(joint.first == model::ground ? joint.point_first : joint.point_second);
      const bool is_new = std::none_of(bearings.begin(), bearings.end(), [&](const PlotPoint& other) {
        return distance(other, place) < joint_radius * scale.unit;
      });
      if (!is_new) continue;
      bearings.push_back(place);
      add_bearing(place, scale.unit, outlines);
    }
  }
  return outlines;
}

std::vector<Outline> draw_pose(const Mechanism& mechanism, const RunResult& result, Eigen::Index row,
                               const Projection& projection, const DrawingScale& scale) {
  return PoseDrawer(mechanism, result, row, projection, scale).outlines();
}

namespace {

constexpr Eigen::Index max_scale_samples = 50;  // of a run; the scale needs no more

struct Box {
  double low_x = 0, high_x = 0, low_y = 0, high_y = 0;
  bool is_empty = true;

  void add(const PlotPoint& p) {
    if (!std::isfinite(p.x) || !std::isfinite(p.y)) return;
    low_x = is_empty ? p.x : std::min(low_x, p.x), high_x = is_empty ? p.x : std::max(high_x, p.x);
    low_y = is_empty ? p.y : std::min(low_y, p.y), high_y = is_empty ? p.y : std::max(high_y, p.y);
    is_empty = false;
  }
};

void add_points(const Mechanism& mechanism, const RunResult& result, const Projection& projection, Box& box) {
  std::vector<Eigen::Index> rows;
  const Eigen::Index last = result.time.size() - 1, count = std::min(last + 1, max_scale_samples);
  for (Eigen::Index i = 0; i < count; ++i) rows.push_back(count > 1 ? i * last / (count - 1) : 0);
  for (const Eigen::Index row : rows) {
    const BodyFrames frames(mechanism, result, row);
    for (int body = 0; body < static_cast<int>(mechanism.bodies.size()); ++body) {
      for (const Vector3& point : outline_points(mechanism, body)) box.add(projection.apply(frames.point(body, point)));
      if (body == model::ground) continue;
      const Rotor rotor = rotor_of(mechanism, body);
      for (const Vector3& rim : circle(rotor.radius))
        if (rotor.radius > 0)
          box.add(projection.apply(frames.point(body, rotor.centre + frame_with_z_along(rotor.axis) * rim)));
    }
  }
}

}  // namespace

DrawingScale drawing_scale(const std::vector<const Mechanism*>& mechanisms, const std::vector<const RunResult*>& runs,
                           const Projection& projection) {
  Box box;
  DrawingScale scale;
  double length = 0;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    add_points(*mechanisms[i], *runs[i], projection, box);
    length = std::max(length, characteristic_length(*mechanisms[i]));
    for (const Body& body : mechanisms[i]->bodies) scale.heaviest_mass = std::max(scale.heaviest_mass, body.mass);
    for (const Attachment& one : mechanisms[i]->attachments)
      scale.heaviest_mass = std::max(scale.heaviest_mass, one.mass);
  }
  const double extent = std::max({box.high_x - box.low_x, box.high_y - box.low_y, 0.2 * length});
  scale.unit = extent / units_across;
  return scale;
}

}  // namespace balance::reports
