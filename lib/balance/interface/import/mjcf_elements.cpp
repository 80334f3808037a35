#include "balance/interface/import/mjcf_elements.hpp"

#include "balance/foundation/base/rotation.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/interface/specification/text_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <set>

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

namespace {

constexpr std::size_t max_included_files = 100;
constexpr int max_mjcf_include_depth = 10;

[[noreturn]] void fail(const XmlElement& at, const std::string& message) {
  throw SpecError({.place = place_of(at, "file"), .message = message});
}

class Includer {
 public:
  explicit Includer(std::vector<std::unique_ptr<const XmlDocument>>& documents) : documents_(documents) {}

  void expand(XmlElement& element, int depth) {
    std::vector<XmlElement> children;
    for (XmlElement& child : element.children) {
      if (child.name != "include") {
        expand(child, depth);
        children.push_back(std::move(child));
        continue;
      }
      for (XmlElement& one : load(child, depth)) children.push_back(std::move(one));
    }
    element.children = std::move(children);
  }

 private:
  std::vector<XmlElement> load(const XmlElement& include, int depth) {
    const std::string* name = include.attribute("file");
    if (name == nullptr || name->empty()) fail(include, "expected file=\"…\"");
    if (depth >= max_mjcf_include_depth)
      fail(include, fmt::format("expected at most {} levels of files that include files", max_mjcf_include_depth));
    if (documents_.size() >= max_included_files)
      fail(include, fmt::format("expected at most {} included files", max_included_files));
    const std::filesystem::path path(*name);
    if (path.is_absolute()) fail(include, "expected a file beside this one, found an absolute path");
    const std::string file = (std::filesystem::path(include.document->file).parent_path() / path).string();
    if (path.extension() != ".xml") fail(include, "expected a file that ends in .xml");
    std::error_code none;
    if (std::filesystem::exists(file, none) && !std::filesystem::is_regular_file(file, none))
      fail(include, "expected a regular file");  // a pipe or a device never ends
    documents_.push_back(parse_xml(read_text_file(file, "included"), file));
    bytes_ += documents_.back()->text.size();
    if (bytes_ > XmlLimits{}.bytes)
      fail(include, fmt::format("expected included files of at most {} MiB, found more", XmlLimits{}.bytes >> 20));
    XmlElement root = documents_.back()->root;
    if (root.name != "mujoco" && root.name != "mujocoinclude")
      fail(include, fmt::format("expected a file with <mujoco> or <mujocoinclude>, found <{}>", root.name));
    expand(root, depth + 1);
    return std::move(root.children);
  }

  std::vector<std::unique_ptr<const XmlDocument>>& documents_;
  std::size_t bytes_ = 0;
};

}  // namespace

ExpandedMjcf expand_mjcf_includes(const XmlDocument& document) {
  ExpandedMjcf tree;
  tree.root = document.root;
  Includer(tree.included).expand(tree.root, 0);
  return tree;
}

MjcfDefaults::MjcfDefaults(const XmlElement& root, ForeignDiagnostics& faults) : faults_(faults) {
  classes_["main"];
  for (const XmlElement& part : root.children) {
    if (part.name != "default") continue;
    // at the top the name is another one of the class that holds for everything
    read(part, "main", "main");
    if (const std::string* name = part.attribute("class"); name != nullptr && *name != "main")
      classes_[*name].parent = "main";
  }
}

void MjcfDefaults::read(const XmlElement& element, const std::string& above, const std::string& name) {
  if (name != above && classes_.count(name) == 0) classes_[name].parent = above;
  for (const XmlElement& child : element.children) {
    if (child.name == "default") continue;
    XmlDefaults& said = classes_[name].attributes[child.name];
    for (const XmlAttribute& one : child.attributes) said[one.name] = one.value;
  }
  for (const XmlElement& child : element.children) {
    if (child.name != "default") continue;
    const std::string* inner = child.attribute("class");
    if (inner == nullptr)
      faults_.add(place_of(child), "default", "expected class=\"…\"");
    else
      read(child, name, *inner);
  }
}

XmlElement MjcfDefaults::apply(const XmlElement& element, const std::string& child_class) const {
  const std::string* own = element.attribute("class");
  const std::string& name = own != nullptr ? *own : child_class;
  const auto found = classes_.find(name.empty() ? "main" : name);
  XmlElement full = element;
  if (found == classes_.end()) {
    faults_.add(place_of(element, "class"), element.name,
                fmt::format("there is no default class {}", quote_for_message(name)));
    return full;
  }
  for (const Class* one = &found->second;;) {
    if (const auto said = one->attributes.find(element.name); said != one->attributes.end())
      full.defaults.push_back(&said->second);
    if (one->parent.empty()) return full;
    one = &classes_.at(one->parent);
  }
}

MjcfCompilerAngles::MjcfCompilerAngles(const XmlElement& root, const XmlAttributeReader& read,
                                       ForeignDiagnostics& faults)
    : read_(read) {
  unit_ = std::numbers::pi / 180;
  for (const XmlElement& part : root.children) {
    if (part.name != "compiler") continue;
    if (const std::string* angle = part.attribute("angle")) {
      if (*angle != "radian" && *angle != "degree")
        faults.add(place_of(part, "angle"), "compiler", "expected radian or degree");
      unit_ = *angle == "radian" ? 1 : std::numbers::pi / 180;
    }
    if (const std::string* sequence = part.attribute("eulerseq")) {
      const bool known = sequence->size() == 3 && sequence->find_first_not_of("xyzXYZ") == std::string::npos;
      if (!known) faults.add(place_of(part, "eulerseq"), "compiler", "expected three letters of x, y, z, X, Y, Z");
      if (known) sequence_ = *sequence;
    }
  }
}

Matrix3 MjcfCompilerAngles::orientation(const XmlElement& at) const {
  if (const auto q = read_.numbers(at, "quat", {4}); !q.empty()) {
    const Eigen::Quaterniond turn(q[0], q[1], q[2], q[3]);
    if (turn.norm() > 0) return turn.normalized().toRotationMatrix();
    read_.report(at, "quat", "expected a quaternion, found zero");
  }
  if (const auto a = read_.numbers(at, "axisangle", {4}); !a.empty()) {
    const Vector3 axis(a[0], a[1], a[2]);
    if (axis.norm() > 0) return rotation_about(axis.normalized(), a[3] * unit_);
    read_.report(at, "axisangle", "expected an axis, found zero");
  }
  if (const auto e = read_.numbers(at, "euler", {3}); !e.empty()) {
    Matrix3 R = Matrix3::Identity();
    for (int i = 0; i < 3; ++i) {
      const char letter = sequence_[static_cast<std::size_t>(i)];
      const auto lower = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
      const Matrix3 turn = rotation_about(Vector3::Unit(lower - 'x'), e[static_cast<std::size_t>(i)] * unit_);
      // small letters: about the turned axes; capitals: about those of the parent
      R = letter == lower ? Matrix3(R * turn) : Matrix3(turn * R);
    }
    return R;
  }
  if (const auto v = read_.numbers(at, "xyaxes", {6}); !v.empty()) {
    const Vector3 x = Vector3(v[0], v[1], v[2]).normalized();
    const Vector3 raw(v[3], v[4], v[5]);
    const Vector3 y = (raw - raw.dot(x) * x).normalized();
    Matrix3 R;
    R << x, y, x.cross(y);
    if (std::abs(R.determinant() - 1) < 1e-6) return R;
    read_.report(at, "xyaxes", "expected two directions that are not parallel");
  }
  if (const auto z = read_.numbers(at, "zaxis", {3}); !z.empty()) {
    const Vector3 direction(z[0], z[1], z[2]);
    if (direction.norm() > 0) return frame_with_z_along(direction.normalized());
    read_.report(at, "zaxis", "expected a direction, found zero");
  }
  return Matrix3::Identity();
}

}  // namespace balance::foreign
