#include "balance/import/spec_text.hpp"

#include "balance/base/elementary.hpp"
#include "balance/base/factorizations.hpp"
#include "balance/base/nearest.hpp"
#include "balance/base/rotation.hpp"
#include "balance/import/spec_page.hpp"
#include "balance/model/joint_names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>

namespace balance::foreign {

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
