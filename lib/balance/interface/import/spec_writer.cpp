#include "balance/interface/import/spec_writer.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/rotation.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/base/unicode_text.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/mechanics/model/mechanism.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace balance::foreign {

// Valid names in a spec for the names in a file.

/// One namespace of a spec: bodies, joints, or the points of one body.
class NameAllocator {
 public:
  /// @param reserved names with a meaning of their own
  explicit NameAllocator(std::set<std::string> reserved) : used_names_(std::move(reserved)) {}

  /// Returns the name itself if it is valid in a spec and not taken, else a similar one.
  std::string allocate(const std::string& requested);

 private:
  std::set<std::string> used_names_;
  std::map<std::string, int> next_suffixes_;  ///< next number to append to a name
};

/// Replaces characters that a name cannot have by `_`, and truncates names that are too long.
std::string sanitise_name(const std::string& raw_name);

namespace {

constexpr std::size_t max_name_bytes = 200;  // YAML allows no keys longer than 1024

}  // namespace

std::string sanitise_name(const std::string& raw_name) {
  std::string name;
  for (std::size_t i = 0; i < raw_name.size() && name.size() < max_name_bytes;) {
    const std::size_t bytes = std::max<std::size_t>(1, decode_utf8(std::string_view(raw_name).substr(i)).bytes);
    const std::string character = raw_name.substr(i, bytes);
    name += is_unicode_identifier("a" + character) ? character : "_";
    i += bytes;
  }
  if (name.empty()) return "unnamed";
  if (!is_unicode_identifier(name)) name.insert(0, "n");
  // what YAML 1.1 does not read as text
  static constexpr std::array<std::string_view, 9> yaml_reserved_words{"y",   "n",    "yes",   "no",  "on",
                                                                       "off", "true", "false", "null"};
  std::string lower = name;
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return std::find(yaml_reserved_words.begin(), yaml_reserved_words.end(), lower) == yaml_reserved_words.end()
             ? name
             : name + "_";
}

std::string NameAllocator::allocate(const std::string& requested) {
  const std::string name = sanitise_name(requested);
  std::string unique = name;
  int& suffix = next_suffixes_.try_emplace(name, 2).first->second;
  while (!used_names_.insert(unique).second) unique = fmt::format("{}_{}", name, suffix++);
  return unique;
}

namespace {

/// Names the points of every joint, spring and frame on its bodies. Ends of joints and springs at a
/// body's origin need no point.
class PointNames {
 public:
  PointNames(const ForeignModel& robot, GeneratedNames& names)
      : robot_(robot), names_(names), allocators_(robot.bodies.size(), NameAllocator({"origin"})) {}

  void run() {
    names_.points.resize(robot_.bodies.size());
    names_.ends.resize(robot_.joints.size());
    for (std::size_t j = 0; j < robot_.joints.size(); ++j) {
      const Joint& joint = robot_.joints[j].joint;
      if (!robot_.joints[j].is_active) continue;
      names_.ends[j].first = add(joint.first, names_.joints[j], joint.point_first);
      names_.ends[j].second = add(joint.second, names_.joints[j], joint.point_second);
    }
    for (const Spring& spring : robot_.springs)
      names_.spring_ends.emplace_back(add(spring.first, spring.name, spring.point_first),
                                      add(spring.second, spring.name, spring.point_second));
    for (std::size_t b = 0; b < robot_.bodies.size(); ++b)
      if (robot_.bodies[b].is_active)
        for (const model::NamedPoint& frame : robot_.bodies[b].body.points)
          names_.points[b].push_back({allocators_[b].allocate(frame.name), frame.position});
  }

 private:
  std::string add(int body, const std::string& requested, const Vector3& position) {
    const auto b = static_cast<std::size_t>(body);
    if (position.isZero(0)) return names_.bodies[b] + ".origin";
    names_.points[b].push_back({allocators_[b].allocate(requested), position});
    return names_.bodies[b] + "." + names_.points[b].back().name;
  }

  const ForeignModel& robot_;
  GeneratedNames& names_;
  std::vector<NameAllocator> allocators_;
};

}  // namespace

GeneratedNames spec_names(const ForeignModel& robot) {
  GeneratedNames names;
  const auto add_renaming = [&](const char* kind, const std::string& old_name, const std::string& new_name) {
    if (old_name != new_name)
      names.renamed.emplace_back(fmt::format("{} {}", kind, quote_for_message(old_name)), new_name);
  };
  NameAllocator bodies({"ground"}), joints({});
  names.bodies.assign(robot.bodies.size(), "ground");
  for (std::size_t b = 1; b < robot.bodies.size(); ++b) {
    if (!robot.bodies[b].is_active) continue;
    names.bodies[b] = bodies.allocate(robot.bodies[b].body.name);
    add_renaming("body", robot.bodies[b].body.name, names.bodies[b]);
  }
  names.joints.resize(robot.joints.size());
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    if (!robot.joints[j].is_active) continue;
    names.joints[j] = joints.allocate(robot.joints[j].joint.name);
    add_renaming("joint", robot.joints[j].joint.name, names.joints[j]);
  }
  PointNames(robot, names).run();
  return names;
}

std::string format_yaml_number(double value) { return fmt::format("{}", value + 0.0); }

std::string format_yaml_list(const std::vector<double>& values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : ", ") + format_yaml_number(value);
  return "[" + text + "]";
}

std::string quote_yaml_text(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : escape_for_terminal(text))
    quoted += c == '"' || c == '\\' ? std::string("\\") + c : std::string(1, c);
  return quoted + "\"";
}

std::string SpecWriterPage::vector(const Vector3& v) const {
  return planar() ? format_yaml_list({v.x(), v.y()}) : format_yaml_list({v.x(), v.y(), v.z()});
}

void SpecWriterPage::line(int indent, const std::string& content, const std::string& comment) {
  text += std::string(static_cast<std::size_t>(indent), ' ') + content;
  if (!comment.empty()) text += (content.empty() ? "# " : "  # ") + escape_for_terminal(comment);
  text += "\n";
}

bool SpecWriterPage::carries(int body) const {
  const auto ends = [body](const auto& one) { return one.first == body || one.second == body; };
  return std::count_if(robot.joints.begin(), robot.joints.end(),
                       [&](const ForeignJoint& one) { return one.is_active && ends(one.joint); }) > 1 ||
         std::any_of(robot.springs.begin(), robot.springs.end(), ends);
}

namespace {

class OptionalSectionWriter {
 public:
  explicit OptionalSectionWriter(SpecWriterPage& page) : page_(page) {}

  void run() {
    write_payloads();
    write_springs();
    write_armatures();
    write_friction();
    write_example_motion();
  }

 private:
  /// A massless body with a motor at the end of a chain may carry a payload: writes one of zero mass to fill in.
  void write_payloads() {
    bool first = true;
    for (std::size_t b = 1; b < page_.robot.bodies.size(); ++b) {
      const Body& body = page_.robot.bodies[b].body;
      if (!page_.robot.bodies[b].is_active || body.mass != 0 || !body.inertia.isZero(0) ||
          page_.carries(static_cast<int>(b)))
        continue;
      if (first) {
        page_.line(0, "");
        page_.line(0, "payloads:", "of massless bodies at the ends of chains: none so far");
      }
      first = false;
      page_.line(2, fmt::format("{}: {{body: {}, at: origin, mass: 0}}", page_.names.bodies[b], page_.names.bodies[b]));
    }
  }

  void write_springs() {
    const auto has_spring = [](const ForeignJoint& one) { return one.is_active && one.stiffness != 0; };
    const auto& joints = page_.robot.joints;
    if (page_.robot.springs.empty() && std::none_of(joints.begin(), joints.end(), has_spring)) return;
    page_.line(0, "");
    page_.line(0, "springs:");
    NameAllocator allocator({});
    for (std::size_t s = 0; s < page_.robot.springs.size(); ++s) {
      const ForeignSpring& spring = page_.robot.springs[s];
      const std::string damping =
          spring.damping == 0 ? "" : fmt::format(", damping: {}", format_yaml_number(spring.damping));
      // a negative free length is that of a spring of none with initial tension
      const std::string tension =
          spring.free_length < 0
              ? fmt::format(", initial_tension: {}", format_yaml_number(-spring.stiffness * spring.free_length))
              : "";
      page_.line(2, fmt::format("{}: {{between: [{}, {}], stiffness: {}, free_length: {}{}{}}}",
                                allocator.allocate(spring.name), page_.names.spring_ends[s].first,
                                page_.names.spring_ends[s].second, format_yaml_number(spring.stiffness),
                                format_yaml_number(std::max(spring.free_length, 0.0)), tension, damping));
    }
    for (std::size_t j = 0; j < joints.size(); ++j)
      if (has_spring(joints[j]))
        page_.line(
            2, fmt::format("{}: {{joint: {}, stiffness: {}, rest: {}}}",
                           allocator.allocate(page_.names.joints[j] + "_spring"), page_.names.joints[j],
                           format_yaml_number(joints[j].stiffness), format_yaml_number(joints[j].spring_reference)));
  }

  /// Only a rotor at the joint can have such an inertia: written as a comment, to be activated if wanted.
  void write_armatures() {
    bool first = true;
    for (std::size_t j = 0; j < page_.robot.joints.size(); ++j) {
      const ForeignJoint& foreign_joint = page_.robot.joints[j];
      if (!foreign_joint.is_active || foreign_joint.armature == 0) continue;
      if (first) {
        page_.line(0, "");
        page_.line(0, "", "The file has armatures, the inertia of geared rotors. As discs they would be:");
        page_.line(0, "", "discs:");
      }
      first = false;
      write_rotor_comment(j, foreign_joint);
    }
  }

  /// On the first body the disc turns by q relative to that body. The ground cannot carry discs, and on the second body
  /// the disc turns twice as fast.
  void write_rotor_comment(std::size_t j, const ForeignJoint& foreign_joint) {
    const Joint& joint = foreign_joint.joint;
    const bool is_on_second = joint.first == 0 || joint.type != JointType::revolute;
    const bool turns_double = is_on_second && joint.type == JointType::revolute;
    const double axial = turns_double ? foreign_joint.armature / 4 : foreign_joint.armature;
    const auto carrier = static_cast<std::size_t>(is_on_second ? joint.second : joint.first);
    const std::string inertia = page_.planar() ? format_yaml_number(axial)
                                               : fmt::format("{{axial: {}, transverse: {}}}", format_yaml_number(axial),
                                                             format_yaml_number(axial / 2));
    page_.line(
        0, "",
        fmt::format("  {}_rotor: {{body: {}, at: {}, follows: {}, inertia: {}}}", page_.names.joints[j],
                    page_.names.bodies[carrier], page_.vector(is_on_second ? joint.point_second : joint.point_first),
                    page_.names.joints[j], inertia));
  }

  void write_friction() {
    bool first = true;
    for (std::size_t j = 0; j < page_.robot.joints.size(); ++j) {
      const ForeignJoint& foreign_joint = page_.robot.joints[j];
      if (!foreign_joint.is_active || (foreign_joint.viscous == 0 && foreign_joint.coulomb == 0)) continue;
      if (first) {
        page_.line(0, "");
        page_.line(0, "friction:");
      }
      first = false;
      page_.line(2, fmt::format("{}: {{viscous: {}, coulomb: {}}}", page_.names.joints[j],
                                format_yaml_number(foreign_joint.viscous), format_yaml_number(foreign_joint.coulomb)));
    }
  }

  void write_example_motion() {
    std::string from_values, to_values;
    for (std::size_t j = 0; j < page_.robot.joints.size(); ++j) {
      const ForeignJoint& one = page_.robot.joints[j];
      if (!one.is_active || !one.is_actuated || joint_degrees_of_freedom(one.joint.type) != 1) continue;
      const auto start_value =
          std::find_if(page_.assembly.begin(), page_.assembly.end(),
                       [&](const AssemblyValue& value) { return value.first == page_.names.joints[j]; });
      const double start = start_value == page_.assembly.end() ? 0 : start_value->second;
      const char* comma = from_values.empty() ? "" : ", ";
      from_values += fmt::format("{}{}: {:.6g}", comma, page_.names.joints[j], start + 0.0);
      to_values += fmt::format("{}{}: {:.6g}", comma, page_.names.joints[j], start + 0.1);
    }
    if (from_values.empty()) return;
    page_.line(0, "");
    page_.line(0, "", "To simulate it, give its start and end, for example:");
    page_.line(0, "",
               fmt::format("motion: {{duration: 1, from: {{joints: {{{}}}}}, to: {{joints: {{{}}}}}}}", from_values,
                           to_values));
  }

  SpecWriterPage& page_;
};

}  // namespace

void write_optional_sections(SpecWriterPage& page) { OptionalSectionWriter(page).run(); }

namespace {

class SpecWriter : private SpecWriterPage {
 public:
  using SpecWriterPage::SpecWriterPage;

  GeneratedSpec run() {
    write_header();
    write_bodies();
    write_joints();
    write_couplings();
    write_lists();
    write_optional_sections(*this);
    return {std::move(text), names.renamed};
  }

 private:
  std::string describe_source(const SourceLocation& place) const {
    const std::string file = std::filesystem::path(place.file).filename().string();
    return place.line > 0 ? fmt::format("from {}:{}", file, place.line) : "";
  }

  void write_header() {
    line(0, "",
         fmt::format("Imported from {} ({}). docs/spec.md describes the language; all numbers are SI.",
                     std::filesystem::path(robot.file).filename().string(), robot.format));
    std::string ignored;
    for (const auto& [what, count] : robot.ignored)
      ignored += fmt::format("{}{} {}", ignored.empty() ? "" : ", ", count, what);
    if (!ignored.empty()) line(0, "", "Left out: " + ignored);
    const std::string name = robot.name.empty() ? std::filesystem::path(robot.file).stem().string() : robot.name;
    line(0, "name: " + quote_yaml_text(name.empty() ? "unnamed" : name));
    line(0, fmt::format("space: {}", planar() ? "planar" : "spatial"));
    if (!robot.gravity.isZero(0)) line(0, "gravity: " + vector(robot.gravity));
  }

  void write_points(int indent, std::size_t body) {
    if (names.points[body].empty()) return;
    line(indent, "points:");
    for (const model::NamedPoint& point : names.points[body])
      line(indent + 2, point.name + ": " + vector(point.position));
  }

  void write_bodies() {
    line(0, "");
    if (!names.points[0].empty()) {
      line(0, "ground:", describe_source(robot.bodies[0].place) + ", " + quote_for_message(robot.bodies[0].body.name));
      write_points(2, 0);
      line(0, "");
    }
    line(0, "bodies:");
    for (std::size_t b = 1; b < robot.bodies.size(); ++b) {
      if (!robot.bodies[b].is_active) continue;
      line(2, names.bodies[b] + ":", describe_source(robot.bodies[b].place));
      write_mass(b);
      write_points(4, b);
    }
  }

  void write_mass(std::size_t b) {
    const Body& body = robot.bodies[b].body;
    line(4, "mass: " + format_yaml_number(body.mass), robot.bodies[b].has_inertial ? "" : "the file gives it none");
    if (body.mass == 0 && body.inertia.isZero(0)) return;
    line(4, "com: " + vector(body.com));
    const bool is_kept_as_given = body.inertia.isZero(0)
                                      ? !carries(static_cast<int>(b))
                                      : body.mass == 0 || violates_triangle_inequality(body.inertia, robot.space);
    const std::string value = format_inertia(body.inertia);
    if (is_kept_as_given)
      line(4, "inertia: {as_given: " + value + "}", "no body can have it: kept as in the file");
    else
      line(4, "inertia: " + value);
  }

  std::string format_inertia(const Matrix3& I) const {
    if (planar()) return format_yaml_number(I(2, 2));
    std::vector<double> entries{I(0, 0), I(1, 1), I(2, 2)};
    if (I(0, 1) != 0 || I(0, 2) != 0 || I(1, 2) != 0) entries.insert(entries.end(), {I(0, 1), I(0, 2), I(1, 2)});
    return format_yaml_list(entries);
  }

  std::string describe_limits(const ForeignJoint& foreign_joint) const {
    const JointLimits& l = foreign_joint.limits;
    const bool is_slide = foreign_joint.joint.type == JointType::prismatic;
    std::string description;
    if (l.lower && l.upper)
      description += fmt::format(", from {} to {} {}", *l.lower, *l.upper, is_slide ? "m" : "rad");
    if (l.rate) description += fmt::format(", at most {} {}", *l.rate, is_slide ? "m/s" : "rad/s");
    if (l.effort) description += fmt::format(", at most {} {}", *l.effort, is_slide ? "N" : "N m");
    return description;
  }

  void write_joints() {
    line(0, "");
    line(0, "joints:");
    for (std::size_t j = 0; j < robot.joints.size(); ++j) {
      const ForeignJoint& foreign_joint = robot.joints[j];
      const Joint& joint = foreign_joint.joint;
      if (!foreign_joint.is_active) continue;
      line(2, names.joints[j] + ":",
           describe_source(foreign_joint.place) + (foreign_joint.note.empty() ? "" : ": " + foreign_joint.note) +
               describe_limits(foreign_joint));
      line(4, fmt::format("type: {}", name_of(joint.type)));
      line(4, fmt::format("connects: [{}, {}]", names.ends[j].first, names.ends[j].second));
      write_axes(joint);
      write_rotation(foreign_joint);
    }
  }

  void write_axes(const Joint& joint) {
    const bool slides = joint.type == JointType::prismatic || joint.type == JointType::pin_slot;
    if (planar() && joint.type == JointType::planar) return line(4, "axis: " + vector(joint.axis2));
    if (joint.type == JointType::spherical || joint.type == JointType::fixed || joint.type == JointType::free ||
        (planar() && !slides))
      return;
    line(4, "axis: " + vector(joint.axis));
    if (joint.type == JointType::universal || joint.type == JointType::planar) line(4, "axis2: " + vector(joint.axis2));
  }

  void write_rotation(const ForeignJoint& foreign_joint) {
    const Matrix3& R = foreign_joint.joint.rotation;
    if (R.isIdentity(0)) return;
    if (planar()) return line(4, "angle: " + format_yaml_number(elementary::atan2(R(1, 0), R(0, 0))));
    if (foreign_joint.rpy) return line(4, "rpy: " + vector(*foreign_joint.rpy));
    const Eigen::Vector4d q = quaternion_of(R);
    line(4, "quaternion: " + format_yaml_list({q[0], q[1], q[2], q[3]}));
  }

  void write_couplings() {
    if (robot.couplings.empty()) return;
    line(0, "");
    line(0, "couplings:");
    for (const ForeignCoupling& one : robot.couplings)
      line(2,
           fmt::format("- {{joint: {}, follows: {}, ratio: {}, offset: {}}}",
                       names.joints[static_cast<std::size_t>(one.follower)],
                       names.joints[static_cast<std::size_t>(one.leader)], format_yaml_number(one.ratio),
                       format_yaml_number(one.offset)),
           describe_source(one.place));
  }

  void write_lists() {
    std::string actuators;
    for (std::size_t j = 0; j < robot.joints.size(); ++j) {
      const ForeignJoint& foreign_joint = robot.joints[j];
      if (!foreign_joint.is_active || !foreign_joint.is_actuated) continue;
      Joint renamed_joint = foreign_joint.joint;
      renamed_joint.name = names.joints[j];
      for (const Coordinate& coordinate : list_coordinates(robot.space, {renamed_joint}))
        if (foreign_joint.actuated_coordinate.empty() ||
            coordinate.name == renamed_joint.name + "." + foreign_joint.actuated_coordinate)
          actuators += (actuators.empty() ? "" : ", ") + coordinate.name;
    }
    line(0, "");
    if (actuators.empty())
      line(0, "", "actuators: []   motors are not specified: import with --actuate, or list them here");
    else
      line(0, "actuators: [" + actuators + "]");
    std::string values;
    for (const auto& [name, value] : assembly)
      values += fmt::format("{}{}: {}", values.empty() ? "" : ", ", name, fmt::format("{:.9g}", value + 0.0));
    if (!values.empty()) line(0, "assembly: {" + values + "}");
  }
};

}  // namespace

bool violates_triangle_inequality(const Matrix3& inertia, SpaceKind space) {
  if (space == SpaceKind::planar) return !(inertia(2, 2) > 0);
  const Eigen::SelfAdjointEigenSolver<Matrix3> solver(inertia, Eigen::EigenvaluesOnly);
  const Vector3& principal = solver.eigenvalues();
  return !(principal[0] > 0) || principal[0] + principal[1] < principal[2] * (1 - 1e-6);
}

GeneratedSpec generate_spec(const ForeignModel& robot, const std::vector<AssemblyValue>& assembly) {
  return SpecWriter(robot, assembly).run();
}

}  // namespace balance::foreign
