#include "balance/import/mjcf_source.hpp"

#include "balance/base/nearest.hpp"
#include "balance/base/rotation.hpp"
#include "balance/spec/text_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <numbers>
#include <set>

namespace balance::foreign {

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
