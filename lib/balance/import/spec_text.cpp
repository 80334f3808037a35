#include "balance/import/spec_text.hpp"

#include "balance/base/factorizations.hpp"
#include "balance/base/nearest.hpp"
#include "balance/base/plain_text.hpp"
#include "balance/base/rotation.hpp"
#include "balance/import/names.hpp"
#include "balance/import/spec_names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>

namespace balance::foreign {

namespace {

/// As few digits as read back the same number; no negative zero.
std::string number(double value) { return fmt::format("{}", value + 0.0); }

std::string list(const std::vector<double>& values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : ", ") + number(value);
  return "[" + text + "]";
}

/// A text of a comment or a scalar: one line, nothing hidden.
std::string one_line(const std::string& text) { return visible(text); }

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : one_line(text)) out += c == '"' || c == '\\' ? std::string("\\") + c : std::string(1, c);
  return out + "\"";
}

const char* type_name(JointType type) {
  switch (type) {
    case JointType::revolute: return "revolute";
    case JointType::prismatic: return "prismatic";
    case JointType::fixed: return "fixed";
    case JointType::pin_slot: return "pin-slot";
    case JointType::cylindrical: return "cylindrical";
    case JointType::universal: return "universal";
    case JointType::spherical: return "spherical";
    case JointType::planar: return "planar";
  }
  return "";
}

class Writer {
 public:
  Writer(const Robot& robot, const std::vector<AssemblyValue>& assembly)
      : robot_(robot), assembly_(assembly), names_(spec_names(robot)) {}

  SpecText run() {
    out_.renamed = names_.renamed;
    head();
    bodies();
    joints();
    couplings();
    lists();
    springs();
    armatures();
    friction();
    ending();
    return std::move(out_);
  }

 private:
  bool planar() const { return robot_.space == SpaceKind::planar; }

  std::string vector(const Vector3& v) const { return planar() ? list({v.x(), v.y()}) : list({v.x(), v.y(), v.z()}); }

  void line(int indent, const std::string& text, const std::string& comment = {}) {
    out_.text += std::string(static_cast<std::size_t>(indent), ' ') + text;
    if (!comment.empty()) out_.text += (text.empty() ? "# " : "  # ") + one_line(comment);
    out_.text += "\n";
  }

  std::string from(const SpecPlace& place) const {
    const std::string file = std::filesystem::path(place.file).filename().string();
    return place.line > 0 ? fmt::format("from {}:{}", file, place.line) : "";
  }

  void head() {
    line(0, "",
         fmt::format("Imported from {} ({}). docs/spec.md describes the language; all numbers are SI.",
                     std::filesystem::path(robot_.file).filename().string(), robot_.format));
    std::string ignored;
    for (const auto& [what, count] : robot_.ignored)
      ignored += fmt::format("{}{} {}", ignored.empty() ? "" : ", ", count, what);
    if (!ignored.empty()) line(0, "", "Left out: " + ignored);
    if (!robot_.name.empty()) line(0, "name: " + quoted(robot_.name));
    line(0, fmt::format("space: {}", planar() ? "planar" : "spatial"));
    if (!robot_.gravity.isZero(0)) line(0, "gravity: " + vector(robot_.gravity));
  }

  void points(int indent, std::size_t body) {
    if (names_.points[body].empty()) return;
    line(indent, "points:");
    for (const NamedPoint& point : names_.points[body]) line(indent + 2, point.name + ": " + vector(point.position));
  }

  void bodies() {
    line(0, "");
    if (!names_.points[0].empty()) {
      line(0, "ground:", from(robot_.bodies[0].place) + ", " + in_quotes(robot_.bodies[0].body.name));
      points(2, 0);
      line(0, "");
    }
    line(0, "bodies:");
    for (std::size_t b = 1; b < robot_.bodies.size(); ++b) {
      if (!robot_.bodies[b].kept) continue;
      line(2, names_.bodies[b] + ":", from(robot_.bodies[b].place));
      mass(b);
      points(4, b);
    }
  }

  void mass(std::size_t b) {
    const Body& body = robot_.bodies[b].body;
    line(4, "mass: " + number(body.mass), robot_.bodies[b].inertial ? "" : "the file gives it none");
    if (body.mass == 0 && body.inertia.isZero(0)) return;
    line(4, "com: " + vector(body.com));
    const bool kept = body.inertia.isZero(0) ? !carries(static_cast<int>(b))
                                             : body.mass == 0 || is_impossible(body.inertia, robot_.space);
    const std::string value = inertia(body.inertia);
    if (kept)
      line(4, "inertia: {as_given: " + value + "}", "no body can have it: kept as the file says it");
    else
      line(4, "inertia: " + value);
  }

  std::string inertia(const Matrix3& I) const {
    if (planar()) return number(I(2, 2));
    std::vector<double> entries{I(0, 0), I(1, 1), I(2, 2)};
    if (I(0, 1) != 0 || I(0, 2) != 0 || I(1, 2) != 0) entries.insert(entries.end(), {I(0, 1), I(0, 2), I(1, 2)});
    return list(entries);
  }

  bool carries(int body) const {
    const auto ends = [body](const auto& one) { return one.first == body || one.second == body; };
    return std::count_if(robot_.joints.begin(), robot_.joints.end(),
                         [&](const RobotJoint& one) { return one.kept && ends(one.joint); }) > 1 ||
           std::any_of(robot_.springs.begin(), robot_.springs.end(), ends);
  }

  std::string limits(const RobotJoint& one) const {
    const Limits& l = one.limits;
    const bool slide = one.joint.type == JointType::prismatic;
    std::string text;
    if (l.lower && l.upper) text += fmt::format(", from {} to {} {}", *l.lower, *l.upper, slide ? "m" : "rad");
    if (l.rate) text += fmt::format(", at most {} {}", *l.rate, slide ? "m/s" : "rad/s");
    if (l.effort) text += fmt::format(", at most {} {}", *l.effort, slide ? "N" : "N m");
    return text;
  }

  void joints() {
    line(0, "");
    line(0, "joints:");
    for (std::size_t j = 0; j < robot_.joints.size(); ++j) {
      const RobotJoint& one = robot_.joints[j];
      const Joint& joint = one.joint;
      if (!one.kept) continue;
      line(2, names_.joints[j] + ":", from(one.place) + (one.note.empty() ? "" : ": " + one.note) + limits(one));
      line(4, fmt::format("type: {}", type_name(joint.type)));
      line(4, fmt::format("connects: [{}, {}]", names_.ends[j].first, names_.ends[j].second));
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

  void rotation(const RobotJoint& one) {
    const Matrix3& R = one.joint.rotation;
    if (R.isIdentity(0)) return;
    if (planar()) return line(4, "angle: " + number(std::atan2(R(1, 0), R(0, 0))));
    if (one.rpy) return line(4, "rpy: " + vector(*one.rpy));
    const Eigen::Vector4d q = quaternion_of(R);
    line(4, "quaternion: " + list({q[0], q[1], q[2], q[3]}));
  }

  void couplings() {
    if (robot_.couplings.empty()) return;
    line(0, "");
    line(0, "couplings:");
    for (const RobotCoupling& one : robot_.couplings)
      line(2,
           fmt::format("- {{joint: {}, follows: {}, ratio: {}, offset: {}}}",
                       names_.joints[static_cast<std::size_t>(one.follower)],
                       names_.joints[static_cast<std::size_t>(one.leader)], number(one.ratio), number(one.offset)),
           from(one.place));
  }

  void lists() {
    std::string actuators;
    for (std::size_t j = 0; j < robot_.joints.size(); ++j) {
      const RobotJoint& one = robot_.joints[j];
      if (!one.kept || !one.driven) continue;
      Joint named = one.joint;
      named.name = names_.joints[j];
      for (const Coordinate& coordinate : list_coordinates(robot_.space, {named}))
        if (one.driven_part.empty() || coordinate.name == named.name + "." + one.driven_part)
          actuators += (actuators.empty() ? "" : ", ") + coordinate.name;
    }
    line(0, "");
    if (actuators.empty())
      line(0, "",
           "actuators: []   which coordinates have motors is not said: import with --actuate, or name them here");
    else
      line(0, "actuators: [" + actuators + "]");
    std::string values;
    for (const auto& [name, value] : assembly_)
      values += fmt::format("{}{}: {}", values.empty() ? "" : ", ", name, fmt::format("{:.9g}", value + 0.0));
    if (!values.empty()) line(0, "assembly: {" + values + "}");
  }

  void springs() {
    if (robot_.springs.empty()) return;
    line(0, "");
    line(0, "springs:");
    Names names({});
    for (std::size_t s = 0; s < robot_.springs.size(); ++s) {
      const Spring& one = robot_.springs[s];
      line(2, fmt::format("{}: {{between: [{}, {}], stiffness: {}, free_length: {}}}", names.give(one.name),
                          names_.spring_ends[s].first, names_.spring_ends[s].second, number(one.stiffness),
                          number(one.free_length)));
    }
  }

  /// What only a rotor on the joint could be, to be taken in by whoever wants it.
  void armatures() {
    bool first = true;
    for (std::size_t j = 0; j < robot_.joints.size(); ++j) {
      const RobotJoint& one = robot_.joints[j];
      if (!one.kept || one.armature == 0) continue;
      if (first) {
        line(0, "");
        line(0, "", "The file has armatures, the inertia of geared rotors. As discs they would be:");
        line(0, "", "discs:");
      }
      first = false;
      const std::string value = number(one.armature);
      line(0, "",
           fmt::format("  {}_rotor: {{body: {}, at: {}, follows: {}, inertia: {}}}", names_.joints[j],
                       names_.bodies[static_cast<std::size_t>(one.joint.second)], vector(one.joint.point_second),
                       names_.joints[j], planar() ? value : list({one.armature, one.armature, one.armature})));
    }
  }

  void friction() {
    bool first = true;
    for (std::size_t j = 0; j < robot_.joints.size(); ++j) {
      const RobotJoint& one = robot_.joints[j];
      if (!one.kept || (one.viscous == 0 && one.coulomb == 0)) continue;
      if (first) {
        line(0, "");
        line(0, "friction:");
      }
      first = false;
      line(2,
           fmt::format("{}: {{viscous: {}, coulomb: {}}}", names_.joints[j], number(one.viscous), number(one.coulomb)));
    }
  }

  void ending() {
    line(0, "");
    line(0, "", "To simulate it, say from where to where, for example:");
    std::string from_values, to_values;
    for (std::size_t j = 0; j < robot_.joints.size(); ++j) {
      const RobotJoint& one = robot_.joints[j];
      if (!one.kept || !one.driven || freedom(one.joint.type) != 1) continue;
      const auto found = std::find_if(assembly_.begin(), assembly_.end(),
                                      [&](const AssemblyValue& value) { return value.first == names_.joints[j]; });
      const double start = found == assembly_.end() ? 0 : found->second;
      const char* comma = from_values.empty() ? "" : ", ";
      from_values += fmt::format("{}{}: {:.6g}", comma, names_.joints[j], start + 0.0);
      to_values += fmt::format("{}{}: {:.6g}", comma, names_.joints[j], start + 0.1);
    }
    line(0, "",
         fmt::format("motion: {{duration: 1, from: {{joints: {{{}}}}}, to: {{joints: {{{}}}}}}}", from_values,
                     to_values));
  }

  const Robot& robot_;
  const std::vector<AssemblyValue>& assembly_;
  SpecText out_;
  const SpecNames names_;
};

}  // namespace

bool is_impossible(const Matrix3& inertia, SpaceKind space) {
  if (space == SpaceKind::planar) return !(inertia(2, 2) > 0);
  const Eigen::SelfAdjointEigenSolver<Matrix3> solver(inertia, Eigen::EigenvaluesOnly);
  const Vector3& principal = solver.eigenvalues();
  return !(principal[0] > 0) || principal[0] + principal[1] < principal[2] * (1 - 1e-6);
}

SpecText spec_text(const Robot& robot, const std::vector<AssemblyValue>& assembly) {
  return Writer(robot, assembly).run();
}

}  // namespace balance::foreign
