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

/// Mass, first moment and inertia about the body's origin, which are additive.
struct MjcfGeomInertia::Sum {
  GeomInertia total;
  Vector3 first_moment = Vector3::Zero();
  Matrix3 second_moment = Matrix3::Zero();
};

namespace {

/// Solid of unit density: volume, and moments of inertia about its axes.
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

/// @param h half of the length
Solid cylinder(double r, double h) {
  const double volume = 2 * std::numbers::pi * r * r * h, transverse = volume * (r * r / 4 + h * h / 3);
  return {volume, {transverse, transverse, volume * r * r / 2}};
}

/// A cylinder with a hemisphere at each end, whose centre of mass lies 3/8 r beyond the end of the cylinder.
Solid capsule(double r, double h) {
  Solid solid = cylinder(r, h);
  const Solid ball = ellipsoid(Vector3::Constant(r));
  const double transverse = ball.moments.x() + ball.volume * h * (h + 0.75 * r);
  solid.volume += ball.volume;
  solid.moments += Vector3(transverse, transverse, ball.moments.z());
  return solid;
}

/// Number of `size` values that a type needs; 0 if it has no volume, or an unknown one.
int count_sizes(const std::string& type) {
  if (type == "sphere") return 1;
  if (type == "capsule" || type == "cylinder") return 2;
  return type == "ellipsoid" || type == "box" ? 3 : 0;
}

/// Describes a geom whose mass cannot be computed; empty for a supported solid.
std::string unknown_shape(const XmlElement& geom, const std::string& type) {
  if (geom.attribute("mesh") != nullptr || type == "mesh") return "a mesh";
  const std::string* shell = geom.attribute("shellinertia");
  if (shell != nullptr && *shell == "true") return "a shell";
  return count_sizes(type) == 0 ? "a geom of type " + quote_for_message(type) : "";
}

Solid solid_of(const std::string& type, const Vector3& s) {
  if (type == "sphere") return ellipsoid(Vector3::Constant(s.x()));
  if (type == "capsule") return capsule(s.x(), s.y());
  if (type == "cylinder") return cylinder(s.x(), s.y());
  return type == "box" ? box(s) : ellipsoid(s);
}

}  // namespace

MjcfGeomInertia::MjcfGeomInertia(const XmlElement& root, const XmlAttributeReader& reader, const MjcfDefaults& defaults,
                                 const MjcfCompilerAngles& angles)
    : reader_(reader), defaults_(defaults), angles_(angles) {
  for (const XmlElement& child : root.children) {
    if (child.name != "compiler") continue;
    if (const std::string* rule = child.attribute("inertiafromgeom")) rule_ = *rule;
    if (rule_ != "auto" && rule_ != "true" && rule_ != "false")
      reader_.report(child, "inertiafromgeom", "expected true, false or auto, found " + quote_for_message(rule_));
    if (const auto range = reader_.numbers(child, "inertiagrouprange", {2}); !range.empty()) {
      first_group_ = range[0];
      last_group_ = range[1];
    }
  }
}

GeomInertia MjcfGeomInertia::compute(const XmlElement& body, const std::string& child_class) const {
  Sum sum;
  add_all(body, {}, child_class, sum);
  GeomInertia& total = sum.total;
  if (!(total.mass > 0)) return total;
  total.com = sum.first_moment / total.mass;
  total.inertia = sum.second_moment + total.mass * skew(total.com) * skew(total.com);
  total.inertia = (0.5 * (total.inertia + total.inertia.transpose())).eval();
  return total;
}

void MjcfGeomInertia::add_all(const XmlElement& parent, const Pose& frame, const std::string& child_class,
                              Sum& sum) const {
  for (const XmlElement& child : parent.children) {
    if (child.name == "geom") add(defaults_.apply(child, child_class), frame, sum);
    if (child.name != "frame") continue;
    const Pose inner{angles_.orientation(child), reader_.vector(child, "pos", Vector3::Zero())};
    const std::string* name = child.attribute("childclass");
    add_all(child, frame * inner, name != nullptr ? *name : child_class, sum);
  }
}

void MjcfGeomInertia::add(const XmlElement& geom, const Pose& frame, Sum& sum) const {
  const std::string* type_attribute = geom.attribute("type");
  const std::string type = type_attribute == nullptr ? "sphere" : *type_attribute;
  const double group = reader_.number(geom, "group", 0), density = reader_.number(geom, "density", 1000);
  const bool is_mass_given = geom.attribute("mass") != nullptr;
  const double given_mass = reader_.number(geom, "mass", 0);
  if (given_mass < 0 || density < 0) reader_.report(geom, is_mass_given ? "mass" : "density", "expected a number ≥ 0");
  if (group < first_group_ || group > last_group_ || (is_mass_given ? given_mass : density) == 0) return;
  if (type == "plane" || type == "hfield") return;  // MuJoCo gives them no mass
  if (sum.total.unsupported_shape.empty()) sum.total.unsupported_shape = unknown_shape(geom, type);
  if (!unknown_shape(geom, type).empty()) return;
  Pose pose{angles_.orientation(geom), reader_.vector(geom, "pos", Vector3::Zero())};
  const auto size = reader_.numbers(geom, "size", {1, 2, 3});
  Vector3 s = Vector3::Zero();
  for (std::size_t i = 0; i < size.size(); ++i) s[static_cast<Eigen::Index>(i)] = size[i];
  std::size_t required_sizes = static_cast<std::size_t>(count_sizes(type));
  if (const auto ends = reader_.numbers(geom, "fromto", {6}); !ends.empty() && type != "sphere") {
    const Vector3 from(ends[0], ends[1], ends[2]), segment = Vector3(ends[3], ends[4], ends[5]) - from;
    if (!(segment.norm() > 1e-14)) return reader_.report(geom, "fromto", "expected two different places");
    pose = {frame_with_z_along(Vector3(segment.normalized())), from + segment / 2};
    s = required_sizes == 2 ? Vector3(s.x(), segment.norm() / 2, 0) : Vector3(s.x(), s.x(), segment.norm() / 2);
    required_sizes = 1;
  }
  const auto size_count = static_cast<Eigen::Index>(count_sizes(type));
  if (size.size() < required_sizes || !(numerics::min_coefficient(s.head(size_count)) > 0))
    return reader_.report(geom, "size", fmt::format("expected {} positive numbers for a {}", required_sizes, type));
  const Solid solid = solid_of(type, s);
  const double scale = is_mass_given ? given_mass / solid.volume : density, mass = scale * solid.volume;
  if (!std::isfinite(scale) || !std::isfinite(mass + scale * solid.moments.sum()))
    return reader_.report(geom, "size", "expected a size that can be computed with");
  pose = frame * pose;
  const Matrix3 central = pose.R * Vector3(scale * solid.moments).asDiagonal() * pose.R.transpose();
  ++sum.total.geoms;
  sum.total.mass += mass;
  sum.first_moment += mass * pose.p;
  sum.second_moment += central - mass * skew(pose.p) * skew(pose.p);
}

namespace {

constexpr std::size_t max_included_files = 100;
constexpr int max_mjcf_include_depth = 10;

[[noreturn]] void fail(const XmlElement& at, const std::string& message) {
  throw SpecError({.place = place_of(at, "file"), .message = message});
}

class IncludeExpander {
 public:
  explicit IncludeExpander(std::vector<std::unique_ptr<const XmlDocument>>& documents) : documents_(documents) {}

  void expand(XmlElement& element, int depth) {
    std::vector<XmlElement> children;
    for (XmlElement& child : element.children) {
      if (child.name != "include") {
        expand(child, depth);
        children.push_back(std::move(child));
        continue;
      }
      for (XmlElement& one : load_include(child, depth)) children.push_back(std::move(one));
    }
    element.children = std::move(children);
  }

 private:
  std::vector<XmlElement> load_include(const XmlElement& include, int depth) {
    const std::string* name = include.attribute("file");
    if (name == nullptr || name->empty()) fail(include, "expected file=\"…\"");
    if (depth >= max_mjcf_include_depth)
      fail(include, fmt::format("expected at most {} levels of files that include files", max_mjcf_include_depth));
    if (documents_.size() >= max_included_files)
      fail(include, fmt::format("expected at most {} included files", max_included_files));
    const std::filesystem::path path(*name);
    if (path.is_absolute()) fail(include, "expected a file next to this one, found an absolute path");
    const std::string file = (std::filesystem::path(include.document->file).parent_path() / path).string();
    if (path.extension() != ".xml") fail(include, "expected a file that ends in .xml");
    std::error_code error;
    if (std::filesystem::exists(file, error) && !std::filesystem::is_regular_file(file, error))
      fail(include, "expected a regular file");  // reading a pipe or a device never ends
    documents_.push_back(parse_xml(specification::read_text_file(file, "included"), file));
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
  IncludeExpander(tree.included).expand(tree.root, 0);
  return tree;
}

MjcfDefaults::MjcfDefaults(const XmlElement& root, ForeignDiagnostics& diagnostics) : diagnostics_(diagnostics) {
  classes_["main"];
  for (const XmlElement& child : root.children) {
    if (child.name != "default") continue;
    // a top-level class name is an alias of the class that applies to all elements
    read(child, "main", "main");
    if (const std::string* name = child.attribute("class"); name != nullptr && *name != "main")
      classes_[*name].parent = "main";
  }
}

void MjcfDefaults::read(const XmlElement& element, const std::string& parent_name, const std::string& name) {
  if (name != parent_name && classes_.count(name) == 0) classes_[name].parent = parent_name;
  for (const XmlElement& child : element.children) {
    if (child.name == "default") continue;
    XmlDefaults& attributes = classes_[name].attributes[child.name];
    for (const XmlAttribute& one : child.attributes) attributes[one.name] = one.value;
  }
  for (const XmlElement& child : element.children) {
    if (child.name != "default") continue;
    const std::string* inner = child.attribute("class");
    if (inner == nullptr)
      diagnostics_.add(place_of(child), "default", "expected class=\"…\"");
    else
      read(child, name, *inner);
  }
}

XmlElement MjcfDefaults::apply(const XmlElement& element, const std::string& child_class) const {
  const std::string* class_attribute = element.attribute("class");
  const std::string& name = class_attribute != nullptr ? *class_attribute : child_class;
  const auto match = classes_.find(name.empty() ? "main" : name);
  XmlElement resolved = element;
  if (match == classes_.end()) {
    diagnostics_.add(place_of(element, "class"), element.name,
                     fmt::format("there is no default class {}", quote_for_message(name)));
    return resolved;
  }
  for (const Class* current = &match->second;;) {
    if (const auto attributes = current->attributes.find(element.name); attributes != current->attributes.end())
      resolved.defaults.push_back(&attributes->second);
    if (current->parent.empty()) return resolved;
    current = &classes_.at(current->parent);
  }
}

MjcfCompilerAngles::MjcfCompilerAngles(const XmlElement& root, const XmlAttributeReader& reader,
                                       ForeignDiagnostics& diagnostics)
    : reader_(reader) {
  unit_ = std::numbers::pi / 180;
  for (const XmlElement& child : root.children) {
    if (child.name != "compiler") continue;
    if (const std::string* angle = child.attribute("angle")) {
      if (*angle != "radian" && *angle != "degree")
        diagnostics.add(place_of(child, "angle"), "compiler", "expected radian or degree");
      unit_ = *angle == "radian" ? 1 : std::numbers::pi / 180;
    }
    if (const std::string* sequence = child.attribute("eulerseq")) {
      const bool is_valid = sequence->size() == 3 && sequence->find_first_not_of("xyzXYZ") == std::string::npos;
      if (!is_valid)
        diagnostics.add(place_of(child, "eulerseq"), "compiler", "expected three letters of x, y, z, X, Y, Z");
      if (is_valid) sequence_ = *sequence;
    }
  }
}

Matrix3 MjcfCompilerAngles::orientation(const XmlElement& at) const {
  if (const auto q = reader_.numbers(at, "quat", {4}); !q.empty()) {
    const Eigen::Quaterniond quaternion(q[0], q[1], q[2], q[3]);
    if (quaternion.norm() > 0) return quaternion.normalized().toRotationMatrix();
    reader_.report(at, "quat", "expected a quaternion, found zero");
  }
  if (const auto a = reader_.numbers(at, "axisangle", {4}); !a.empty()) {
    const Vector3 axis(a[0], a[1], a[2]);
    if (axis.norm() > 0) return rotation_about(axis.normalized(), a[3] * unit_);
    reader_.report(at, "axisangle", "expected an axis, found zero");
  }
  if (const auto e = reader_.numbers(at, "euler", {3}); !e.empty()) {
    Matrix3 R = Matrix3::Identity();
    for (int i = 0; i < 3; ++i) {
      const char letter = sequence_[static_cast<std::size_t>(i)];
      const auto lower_case = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
      const Matrix3 axis_rotation =
          rotation_about(Vector3::Unit(lower_case - 'x'), e[static_cast<std::size_t>(i)] * unit_);
      // lower case: about the rotated axes; upper case: about those of the parent
      R = letter == lower_case ? Matrix3(R * axis_rotation) : Matrix3(axis_rotation * R);
    }
    return R;
  }
  if (const auto v = reader_.numbers(at, "xyaxes", {6}); !v.empty()) {
    const Vector3 x = Vector3(v[0], v[1], v[2]).normalized();
    const Vector3 second_direction(v[3], v[4], v[5]);
    const Vector3 y = (second_direction - second_direction.dot(x) * x).normalized();
    Matrix3 R;
    R << x, y, x.cross(y);
    if (std::abs(R.determinant() - 1) < 1e-6) return R;
    reader_.report(at, "xyaxes", "expected two directions that are not parallel");
  }
  if (const auto z = reader_.numbers(at, "zaxis", {3}); !z.empty()) {
    const Vector3 direction(z[0], z[1], z[2]);
    if (direction.norm() > 0) return frame_with_z_along(direction.normalized());
    reader_.report(at, "zaxis", "expected a direction, found zero");
  }
  return Matrix3::Identity();
}

}  // namespace balance::foreign
