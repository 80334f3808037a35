#include "balance/import/mjcf_geoms.hpp"

#include "balance/base/extrema.hpp"
#include "balance/base/nearest.hpp"
#include "balance/base/rotation.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace balance::foreign {

/// Mass, first moment and inertia about the body's origin: they add up.
struct MjcfGeomInertia::Sum {
  GeomInertia all;
  Vector3 first = Vector3::Zero();
  Matrix3 second = Matrix3::Zero();
};

namespace {

/// A solid of density one: volume, and moments of inertia about its axes.
struct Solid {
  double volume = 0;
  Vector3 moments = Vector3::Zero();
};

Solid ellipsoid(const Vector3& s) {
  const double volume = 4.0 / 3 * std::numbers::pi * s.prod();
  const Vector3 q = s.cwiseAbs2();
  return {volume, volume / 5 * Vector3(q.y() + q.z(), q.x() + q.z(), q.x() + q.y())};
}

Solid box(const Vector3& s) {
  const double volume = 8 * s.prod();
  const Vector3 q = s.cwiseAbs2();
  return {volume, volume / 3 * Vector3(q.y() + q.z(), q.x() + q.z(), q.x() + q.y())};
}

/// @param h half of its length
Solid cylinder(double r, double h) {
  const double volume = 2 * std::numbers::pi * r * r * h, across = volume * (r * r / 4 + h * h / 3);
  return {volume, {across, across, volume * r * r / 2}};
}

/// A cylinder with half a ball at each end, whose centre of mass lies 3/8 r beyond the cylinder's.
Solid capsule(double r, double h) {
  Solid sum = cylinder(r, h);
  const Solid ball = ellipsoid(Vector3::Constant(r));
  const double across = ball.moments.x() + ball.volume * h * (h + 0.75 * r);
  sum.volume += ball.volume;
  sum.moments += Vector3(across, across, ball.moments.z());
  return sum;
}

/// Numbers of `size` that a type needs; 0: it has no volume, or none that is known here.
int sizes_of(const std::string& type) {
  if (type == "sphere") return 1;
  if (type == "capsule" || type == "cylinder") return 2;
  return type == "ellipsoid" || type == "box" ? 3 : 0;
}

/// What has mass and cannot be weighed; empty for a solid that can.
std::string unknown_shape(const XmlElement& geom, const std::string& type) {
  if (geom.attribute("mesh") != nullptr || type == "mesh") return "a mesh";
  const std::string* shell = geom.attribute("shellinertia");
  if (shell != nullptr && *shell == "true") return "a shell";
  return sizes_of(type) == 0 ? "a geom of type " + quote_for_message(type) : "";
}

Solid solid_of(const std::string& type, const Vector3& s) {
  if (type == "sphere") return ellipsoid(Vector3::Constant(s.x()));
  if (type == "capsule") return capsule(s.x(), s.y());
  if (type == "cylinder") return cylinder(s.x(), s.y());
  return type == "box" ? box(s) : ellipsoid(s);
}

}  // namespace

MjcfGeomInertia::MjcfGeomInertia(const XmlElement& root, const XmlAttributeReader& read, const MjcfDefaults& defaults,
                                 const MjcfCompilerAngles& angles)
    : read_(read), defaults_(defaults), angles_(angles) {
  for (const XmlElement& part : root.children) {
    if (part.name != "compiler") continue;
    if (const std::string* rule = part.attribute("inertiafromgeom")) rule_ = *rule;
    if (rule_ != "auto" && rule_ != "true" && rule_ != "false")
      read_.report(part, "inertiafromgeom", "expected true, false or auto, found " + quote_for_message(rule_));
    if (const auto range = read_.numbers(part, "inertiagrouprange", {2}); !range.empty()) {
      first_group_ = range[0];
      last_group_ = range[1];
    }
  }
}

GeomInertia MjcfGeomInertia::compute(const XmlElement& body, const std::string& child_class) const {
  Sum sum;
  add_all(body, {}, child_class, sum);
  GeomInertia& all = sum.all;
  if (!(all.mass > 0)) return all;
  all.com = sum.first / all.mass;
  all.inertia = sum.second + all.mass * skew(all.com) * skew(all.com);
  all.inertia = (0.5 * (all.inertia + all.inertia.transpose())).eval();
  return all;
}

void MjcfGeomInertia::add_all(const XmlElement& parent, const Pose& frame, const std::string& child_class,
                              Sum& sum) const {
  for (const XmlElement& child : parent.children) {
    if (child.name == "geom") add(defaults_.apply(child, child_class), frame, sum);
    if (child.name != "frame") continue;
    const Pose inner{angles_.orientation(child), read_.vector(child, "pos", Vector3::Zero())};
    const std::string* name = child.attribute("childclass");
    add_all(child, frame * inner, name != nullptr ? *name : child_class, sum);
  }
}

void MjcfGeomInertia::add(const XmlElement& geom, const Pose& frame, Sum& sum) const {
  const std::string* given = geom.attribute("type");
  const std::string type = given == nullptr ? "sphere" : *given;
  const double group = read_.number(geom, "group", 0), density = read_.number(geom, "density", 1000);
  const bool weighed = geom.attribute("mass") != nullptr;
  const double stated = read_.number(geom, "mass", 0);
  if (stated < 0 || density < 0) read_.report(geom, weighed ? "mass" : "density", "expected a number ≥ 0");
  if (group < first_group_ || group > last_group_ || (weighed ? stated : density) == 0) return;
  if (type == "plane" || type == "hfield") return;  // MuJoCo gives them no mass
  if (sum.all.unsupported_shape.empty()) sum.all.unsupported_shape = unknown_shape(geom, type);
  if (!unknown_shape(geom, type).empty()) return;
  Pose pose{angles_.orientation(geom), read_.vector(geom, "pos", Vector3::Zero())};
  const auto size = read_.numbers(geom, "size", {1, 2, 3});
  Vector3 s = Vector3::Zero();
  for (std::size_t i = 0; i < size.size(); ++i) s[static_cast<Eigen::Index>(i)] = size[i];
  std::size_t needed = static_cast<std::size_t>(sizes_of(type));
  if (const auto ends = read_.numbers(geom, "fromto", {6}); !ends.empty() && type != "sphere") {
    const Vector3 from(ends[0], ends[1], ends[2]), way = Vector3(ends[3], ends[4], ends[5]) - from;
    if (!(way.norm() > 1e-14)) return read_.report(geom, "fromto", "expected two places that differ");
    pose = {frame_with_z_along(Vector3(way.normalized())), from + way / 2};
    s = needed == 2 ? Vector3(s.x(), way.norm() / 2, 0) : Vector3(s.x(), s.x(), way.norm() / 2);
    needed = 1;
  }
  const auto used = static_cast<Eigen::Index>(sizes_of(type));
  if (size.size() < needed || !(min_coefficient(s.head(used)) > 0))
    return read_.report(geom, "size", fmt::format("expected {} positive numbers for a {}", needed, type));
  const Solid solid = solid_of(type, s);
  const double scale = weighed ? stated / solid.volume : density, mass = scale * solid.volume;
  if (!std::isfinite(scale) || !std::isfinite(mass + scale * solid.moments.sum()))
    return read_.report(geom, "size", "expected a size that can be computed with");
  pose = frame * pose;
  const Matrix3 central = pose.R * Vector3(scale * solid.moments).asDiagonal() * pose.R.transpose();
  ++sum.all.geoms;
  sum.all.mass += mass;
  sum.first += mass * pose.p;
  sum.second += central - mass * skew(pose.p) * skew(pose.p);
}

}  // namespace balance::foreign
