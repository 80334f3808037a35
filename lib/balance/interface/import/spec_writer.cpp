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

// Names that a spec can have, for names that a file has.

/// One namespace of a spec: bodies, joints, the points of a body.
class NameAllocator {
 public:
  /// @param reserved names that have a meaning of their own
  explicit NameAllocator(std::set<std::string> reserved) : taken_(std::move(reserved)) {}

  /// The name itself if a spec can have it and it is not taken, else one like it.
  std::string allocate(const std::string& wanted);

 private:
  std::set<std::string> taken_;
  std::map<std::string, int> next_;  ///< number to try behind a name
};

/// Characters that a name cannot have become `_`, and what no name has room for is cut off.
std::string sanitise_name(const std::string& wanted);

namespace {

constexpr std::size_t max_name_bytes = 200;  // bytes; YAML knows no keys of more than 1024

}  // namespace

std::string sanitise_name(const std::string& wanted) {
  std::string name;
  for (std::size_t i = 0; i < wanted.size() && name.size() < max_name_bytes;) {
    const std::size_t bytes = std::max<std::size_t>(1, decode_utf8(std::string_view(wanted).substr(i)).bytes);
    const std::string character = wanted.substr(i, bytes);
    name += is_unicode_identifier("a" + character) ? character : "_";
    i += bytes;
  }
  if (name.empty()) return "unnamed";
  if (!is_unicode_identifier(name)) name.insert(0, "n");
  // what YAML 1.1 takes for something else than text
  static constexpr std::array<std::string_view, 9> yaml_reserved_words{"y",   "n",    "yes",   "no",  "on",
                                                                       "off", "true", "false", "null"};
  std::string lower = name;
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return std::find(yaml_reserved_words.begin(), yaml_reserved_words.end(), lower) == yaml_reserved_words.end()
             ? name
             : name + "_";
}

std::string NameAllocator::allocate(const std::string& wanted) {
  const std::string name = sanitise_name(wanted);
  std::string unique = name;
  int& next = next_.try_emplace(name, 2).first->second;
  while (!taken_.insert(unique).second) unique = fmt::format("{}_{}", name, next++);
  return unique;
}

namespace {

/// Every joint, spring and frame has a point of its own on each of its bodies, but for what is at the body's origin.
class PointNames {
 public:
  PointNames(const ForeignModel& robot, GeneratedNames& names)
      : robot_(robot), names_(names), taken_(robot.bodies.size(), NameAllocator({"origin"})) {}

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
        for (const NamedPoint& frame : robot_.bodies[b].body.points)
          names_.points[b].push_back({taken_[b].allocate(frame.name), frame.position});
  }

 private:
  std::string add(int body, const std::string& wanted, const Vector3& position) {
    const auto b = static_cast<std::size_t>(body);
    if (position.isZero(0)) return names_.bodies[b] + ".origin";
    names_.points[b].push_back({taken_[b].allocate(wanted), position});
    return names_.bodies[b] + "." + names_.points[b].back().name;
  }

  const ForeignModel& robot_;
  GeneratedNames& names_;
  std::vector<NameAllocator> taken_;
};

}  // namespace

GeneratedNames spec_names(const ForeignModel& robot) {
  GeneratedNames names;
  const auto remember = [&](const char* kind, const std::string& before, const std::string& after) {
    if (before != after) names.renamed.emplace_back(fmt::format("{} {}", kind, quote_for_message(before)), after);
  };
  NameAllocator bodies({"ground"}), joints({});
  names.bodies.assign(robot.bodies.size(), "ground");
  for (std::size_t b = 1; b < robot.bodies.size(); ++b) {
    if (!robot.bodies[b].is_active) continue;
    names.bodies[b] = bodies.allocate(robot.bodies[b].body.name);
    remember("body", robot.bodies[b].body.name, names.bodies[b]);
  }
  names.joints.resize(robot.joints.size());
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    if (!robot.joints[j].is_active) continue;
    names.joints[j] = joints.allocate(robot.joints[j].joint.name);
    remember("joint", robot.joints[j].joint.name, names.joints[j]);
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
  std::string out = "\"";
  for (const char c : escape_for_terminal(text))
    out += c == '"' || c == '\\' ? std::string("\\") + c : std::string(1, c);
  return out + "\"";
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
    payloads();
    springs();
    armatures();
    friction();
    ending();
  }

 private:
  /// A body at the end of a chain has a motor but no mass: what it carries may be written here.
  void payloads() {
    bool first = true;
    for (std::size_t b = 1; b < page_.robot.bodies.size(); ++b) {
      const Body& body = page_.robot.bodies[b].body;
      if (!page_.robot.bodies[b].is_active || body.mass != 0 || !body.inertia.isZero(0) ||
          page_.carries(static_cast<int>(b)))
        continue;
      if (first) {
        page_.line(0, "");
        page_.line(0, "payloads:", "of bodies without mass at the ends of chains: nothing, so far");
      }
      first = false;
      page_.line(2, fmt::format("{}: {{body: {}, at: origin, mass: 0}}", page_.names.bodies[b], page_.names.bodies[b]));
    }
  }

  void springs() {
    const auto sprung = [](const ForeignJoint& one) { return one.is_active && one.stiffness != 0; };
    const auto& joints = page_.robot.joints;
    if (page_.robot.springs.empty() && std::none_of(joints.begin(), joints.end(), sprung)) return;
    page_.line(0, "");
    page_.line(0, "springs:");
    NameAllocator given({});
    for (std::size_t s = 0; s < page_.robot.springs.size(); ++s) {
      const Spring& one = page_.robot.springs[s];
      page_.line(2, fmt::format("{}: {{between: [{}, {}], stiffness: {}, free_length: {}}}", given.allocate(one.name),
                                page_.names.spring_ends[s].first, page_.names.spring_ends[s].second,
                                format_yaml_number(one.stiffness), format_yaml_number(one.free_length)));
    }
    for (std::size_t j = 0; j < joints.size(); ++j)
      if (sprung(joints[j]))
        page_.line(
            2, fmt::format("{}: {{joint: {}, stiffness: {}, rest: {}}}",
                           given.allocate(page_.names.joints[j] + "_spring"), page_.names.joints[j],
                           format_yaml_number(joints[j].stiffness), format_yaml_number(joints[j].spring_reference)));
  }

  /// What only a rotor on the joint could be, to be taken in where it is wanted.
  void armatures() {
    bool first = true;
    for (std::size_t j = 0; j < page_.robot.joints.size(); ++j) {
      const ForeignJoint& one = page_.robot.joints[j];
      if (!one.is_active || one.armature == 0) continue;
      if (first) {
        page_.line(0, "");
        page_.line(0, "", "The file has armatures, the inertia of geared rotors. As discs they would be:");
        page_.line(0, "", "discs:");
      }
      first = false;
      disc_for(j, one);
    }
  }

  /// On the first body it turns by q against that body; on the ground nothing can be carried, and on the second it turns twice as fast.
  void disc_for(std::size_t j, const ForeignJoint& one) {
    const Joint& joint = one.joint;
    const bool on_second = joint.first == 0 || joint.type != JointType::revolute;
    const bool doubled = on_second && joint.type == JointType::revolute;
    const double axial = doubled ? one.armature / 4 : one.armature;
    const auto carrier = static_cast<std::size_t>(on_second ? joint.second : joint.first);
    const std::string inertia = page_.planar() ? format_yaml_number(axial)
                                               : fmt::format("{{axial: {}, transverse: {}}}", format_yaml_number(axial),
                                                             format_yaml_number(axial / 2));
    page_.line(
        0, "",
        fmt::format("  {}_rotor: {{body: {}, at: {}, follows: {}, inertia: {}}}", page_.names.joints[j],
                    page_.names.bodies[carrier], page_.vector(on_second ? joint.point_second : joint.point_first),
                    page_.names.joints[j], inertia));
  }

  void friction() {
    bool first = true;
    for (std::size_t j = 0; j < page_.robot.joints.size(); ++j) {
      const ForeignJoint& one = page_.robot.joints[j];
      if (!one.is_active || (one.viscous == 0 && one.coulomb == 0)) continue;
      if (first) {
        page_.line(0, "");
        page_.line(0, "friction:");
      }
      first = false;
      page_.line(2, fmt::format("{}: {{viscous: {}, coulomb: {}}}", page_.names.joints[j],
                                format_yaml_number(one.viscous), format_yaml_number(one.coulomb)));
    }
  }

  void ending() {
    std::string from_values, to_values;
    for (std::size_t j = 0; j < page_.robot.joints.size(); ++j) {
      const ForeignJoint& one = page_.robot.joints[j];
      if (!one.is_active || !one.is_actuated || joint_degrees_of_freedom(one.joint.type) != 1) continue;
      const auto found = std::find_if(page_.assembly.begin(), page_.assembly.end(),
                                      [&](const AssemblyValue& value) { return value.first == page_.names.joints[j]; });
      const double start = found == page_.assembly.end() ? 0 : found->second;
      const char* comma = from_values.empty() ? "" : ", ";
      from_values += fmt::format("{}{}: {:.6g}", comma, page_.names.joints[j], start + 0.0);
      to_values += fmt::format("{}{}: {:.6g}", comma, page_.names.joints[j], start + 0.1);
    }
    if (from_values.empty()) return;
    page_.line(0, "");
    page_.line(0, "", "To simulate it, say from where to where, for example:");
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
    head();
    bodies();
    joints();
    couplings();
    lists();
    write_optional_sections(*this);
    return {std::move(text), names.renamed};
  }

 private:
  std::string from(const SourceLocation& place) const {
    const std::string file = std::filesystem::path(place.file).filename().string();
    return place.line > 0 ? fmt::format("from {}:{}", file, place.line) : "";
  }

  void head() {
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

  void points(int indent, std::size_t body) {
    if (names.points[body].empty()) return;
    line(indent, "points:");
    for (const NamedPoint& point : names.points[body]) line(indent + 2, point.name + ": " + vector(point.position));
  }

  void bodies() {
    line(0, "");
    if (!names.points[0].empty()) {
      line(0, "ground:", from(robot.bodies[0].place) + ", " + quote_for_message(robot.bodies[0].body.name));
      points(2, 0);
      line(0, "");
    }
    line(0, "bodies:");
    for (std::size_t b = 1; b < robot.bodies.size(); ++b) {
      if (!robot.bodies[b].is_active) continue;
      line(2, names.bodies[b] + ":", from(robot.bodies[b].place));
      mass(b);
      points(4, b);
    }
  }

  void mass(std::size_t b) {
    const Body& body = robot.bodies[b].body;
    line(4, "mass: " + format_yaml_number(body.mass), robot.bodies[b].has_inertial ? "" : "the file gives it none");
    if (body.mass == 0 && body.inertia.isZero(0)) return;
    line(4, "com: " + vector(body.com));
    const bool kept = body.inertia.isZero(0)
                          ? !carries(static_cast<int>(b))
                          : body.mass == 0 || violates_triangle_inequality(body.inertia, robot.space);
    const std::string value = inertia(body.inertia);
    if (kept)
      line(4, "inertia: {as_given: " + value + "}", "no body can have it: kept as the file says it");
    else
      line(4, "inertia: " + value);
  }

  std::string inertia(const Matrix3& I) const {
    if (planar()) return format_yaml_number(I(2, 2));
    std::vector<double> entries{I(0, 0), I(1, 1), I(2, 2)};
    if (I(0, 1) != 0 || I(0, 2) != 0 || I(1, 2) != 0) entries.insert(entries.end(), {I(0, 1), I(0, 2), I(1, 2)});
    return format_yaml_list(entries);
  }

  std::string limits(const ForeignJoint& one) const {
    const JointLimits& l = one.limits;
    const bool slide = one.joint.type == JointType::prismatic;
    std::string said;
    if (l.lower && l.upper) said += fmt::format(", from {} to {} {}", *l.lower, *l.upper, slide ? "m" : "rad");
    if (l.rate) said += fmt::format(", at most {} {}", *l.rate, slide ? "m/s" : "rad/s");
    if (l.effort) said += fmt::format(", at most {} {}", *l.effort, slide ? "N" : "N m");
    return said;
  }

  void joints() {
    line(0, "");
    line(0, "joints:");
    for (std::size_t j = 0; j < robot.joints.size(); ++j) {
      const ForeignJoint& one = robot.joints[j];
      const Joint& joint = one.joint;
      if (!one.is_active) continue;
      line(2, names.joints[j] + ":", from(one.place) + (one.note.empty() ? "" : ": " + one.note) + limits(one));
      line(4, fmt::format("type: {}", name_of(joint.type)));
      line(4, fmt::format("connects: [{}, {}]", names.ends[j].first, names.ends[j].second));
      axes(joint);
      rotation(one);
    }
  }

  void axes(const Joint& joint) {
    const bool slides = joint.type == JointType::prismatic || joint.type == JointType::pin_slot;
    if (joint.type == JointType::spherical || joint.type == JointType::fixed || (planar() && !slides)) return;
    line(4, "axis: " + vector(joint.axis));
    if (joint.type == JointType::universal || joint.type == JointType::planar) line(4, "axis2: " + vector(joint.axis2));
  }

  void rotation(const ForeignJoint& one) {
    const Matrix3& R = one.joint.rotation;
    if (R.isIdentity(0)) return;
    if (planar()) return line(4, "angle: " + format_yaml_number(elementary::atan2(R(1, 0), R(0, 0))));
    if (one.rpy) return line(4, "rpy: " + vector(*one.rpy));
    const Eigen::Vector4d q = quaternion_of(R);
    line(4, "quaternion: " + format_yaml_list({q[0], q[1], q[2], q[3]}));
  }

  void couplings() {
    if (robot.couplings.empty()) return;
    line(0, "");
    line(0, "couplings:");
    for (const ForeignCoupling& one : robot.couplings)
      line(2,
           fmt::format("- {{joint: {}, follows: {}, ratio: {}, offset: {}}}",
                       names.joints[static_cast<std::size_t>(one.follower)],
                       names.joints[static_cast<std::size_t>(one.leader)], format_yaml_number(one.ratio),
                       format_yaml_number(one.offset)),
           from(one.place));
  }

  void lists() {
    std::string actuators;
    for (std::size_t j = 0; j < robot.joints.size(); ++j) {
      const ForeignJoint& one = robot.joints[j];
      if (!one.is_active || !one.is_actuated) continue;
      Joint named = one.joint;
      named.name = names.joints[j];
      for (const Coordinate& coordinate : list_coordinates(robot.space, {named}))
        if (one.actuated_coordinate.empty() || coordinate.name == named.name + "." + one.actuated_coordinate)
          actuators += (actuators.empty() ? "" : ", ") + coordinate.name;
    }
    line(0, "");
    if (actuators.empty())
      line(0, "",
           "actuators: []   which coordinates have motors is not said: import with --actuate, or name them here");
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
