#include "balance/import/mjcf_relations.hpp"

#include "balance/base/nearest.hpp"
#include "balance/import/closures.hpp"

#include <fmt/format.h>

#include <optional>

namespace balance::foreign {

namespace {

class MjcfRelationReader {
 public:
  MjcfRelationReader(const XmlElement& root, const MjcfDefaults& defaults, ForeignDiagnostics& faults,
                     ForeignModel& robot)
      : root_(root), defaults_(defaults), read_(faults), robot_(robot) {}

  void run() {
    poses_ = zero_configuration_poses(robot_);
    collect_sites(root_, "world");
    for (const XmlElement& section : root_.children) {
      if (section.name == "equality")
        for (const XmlElement& one : section.children) read_equality(defaults_.apply(one, ""));
      if (section.name == "actuator")
        for (const XmlElement& one : section.children) read_actuator(one);
    }
  }

 private:
  struct Site {
    std::string body;
    Vector3 position;
  };

  /// Sites are places; those inside a <frame> are not known.
  void collect_sites(const XmlElement& element, const std::string& body) {
    for (const XmlElement& child : element.children) {
      if (child.name == "site")
        if (const std::string* name = child.attribute("name"))
          sites_[*name] = {body, read_.vector(child, "pos", Vector3::Zero())};
      const std::string* name = child.name == "body" ? child.attribute("name") : nullptr;
      if (child.name == "worldbody" || child.name == "body") collect_sites(child, name != nullptr ? *name : body);
    }
  }

  int find_body(const XmlElement& at, const char* attribute) {
    const std::string* name = at.attribute(attribute);
    if (name == nullptr) return 0;  // the world
    const int found = robot_.find_body(*name);
    if (found < 0) read_.report(at, attribute, fmt::format("there is no body {}", quote_for_message(*name)));
    return found;
  }

  std::string name_of(const XmlElement& at, const char* fallback) {
    const std::string* name = at.attribute("name");
    return name != nullptr ? *name : fmt::format("{}{}", fallback, ++unnamed_);
  }

  void read_equality(const XmlElement& at) {
    const std::string* active = at.attribute("active");
    if (active != nullptr && *active == "false") {
      ++robot_.ignored["inactive equality"];
    } else if (at.name == "connect") {
      read_connect(at);
    } else if (at.name == "weld") {
      read_weld(at);
    } else if (at.name == "joint") {
      read_coupling(at);
    } else {
      ++robot_.ignored["equality " + at.name];
      robot_.findings.push_back({Severity::warning, place_of(at), "equality", "equality " + at.name, "is left out"});
    }
  }

  Pose between(int first, int second) const {
    return poses_[static_cast<std::size_t>(first)].inverse() * poses_[static_cast<std::size_t>(second)];
  }

  /// The place in the second body follows from the model's pose; two sites are said on both.
  void read_connect(const XmlElement& at) {
    if (at.attribute("site1") != nullptr) return read_site_connect(at);
    const int first = find_body(at, "body1"), second = find_body(at, "body2");
    if (first < 0 || second < 0) return;
    if (at.attribute("anchor") == nullptr) return read_.report(at, "", "expected anchor=\"x y z\"");
    if (first == second) return read_.report(at, "", "expected two bodies, found one");
    const Vector3 anchor = read_.vector(at, "anchor", Vector3::Zero());
    const Pose back = between(second, first);
    add_loop_joint(robot_, name_of(at, "connect"), JointType::spherical, {first, {Matrix3::Identity(), anchor}},
                   {second, {back.R, back.p + back.R * anchor}}, Vector3::UnitZ(), place_of(at));
  }

  void read_site_connect(const XmlElement& at) {
    const auto end = [&](const char* attribute) -> std::optional<BodyFrame> {
      const std::string* name = at.attribute(attribute);
      const auto found = name == nullptr ? sites_.end() : sites_.find(*name);
      const int body = found == sites_.end() ? -1 : robot_.find_body(found->second.body);
      if (body < 0) {
        read_.report(at, attribute, "expected the name of a site of a body that has a name");
        return {};
      }
      return BodyFrame{body, {Matrix3::Identity(), found->second.position}};
    };
    const auto first = end("site1"), second = end("site2");
    if (!first || !second) return;
    if (first->body == second->body) return read_.report(at, "", "expected two bodies, found one");
    BodyFrame turned = *second;
    turned.pose.R = between(second->body, first->body).R;
    add_loop_joint(robot_, name_of(at, "connect"), JointType::spherical, *first, turned, Vector3::UnitZ(),
                   place_of(at));
  }

  void read_weld(const XmlElement& at) {
    const int first = find_body(at, "body1"), second = find_body(at, "body2");
    if (first < 0 || second < 0) return;
    if (first == second) return read_.report(at, "", "expected two bodies, found one");
    Pose pose = between(first, second);
    if (const auto v = read_.numbers(at, "relpose", {7}); !v.empty()) {
      const Eigen::Quaterniond turn(v[3], v[4], v[5], v[6]);
      if (turn.norm() > 0) pose = {turn.normalized().toRotationMatrix(), {v[0], v[1], v[2]}};
    }
    add_loop_joint(robot_, name_of(at, "weld"), JointType::fixed, {first, pose}, {second, {}}, Vector3::UnitZ(),
                   place_of(at));
  }

  int find_joint(const XmlElement& at, const char* attribute) {
    const std::string name = read_.required_text(at, attribute);
    const int found = name.empty() ? -1 : robot_.find_joint(name);
    if (!name.empty() &&
        (found < 0 || joint_degrees_of_freedom(robot_.joints[static_cast<std::size_t>(found)].joint.type) != 1)) {
      read_.report(at, attribute, fmt::format("expected a hinge or slide, found {}", quote_for_message(name)));
      return -1;
    }
    return found;
  }

  /// q1 − ref1 = c0 + c1 (q2 − ref2) + …; without joint2 q1 stands still.
  void read_coupling(const XmlElement& at) {
    const int follower = find_joint(at, "joint1");
    auto c = read_.numbers(at, "polycoef", {1, 2, 3, 4, 5});
    if (c.empty()) c = {0, 1};
    c.resize(5);
    if (follower < 0) return;
    if (at.attribute("joint2") == nullptr)
      return read_.report(at, "joint2", "expected a second joint: a joint that stands still is a body without one");
    const int leader = find_joint(at, "joint2");
    if (leader < 0) return;
    if (c[2] != 0 || c[3] != 0 || c[4] != 0 || c[1] == 0 || leader == follower)
      return read_.report(at, "polycoef", "expected a linear relation between two joints");
    robot_.couplings.push_back({follower, leader, c[1], c[0], place_of(at)});
  }

  void read_actuator(const XmlElement& at) {
    const std::string* name = at.attribute("joint");
    if (name == nullptr) name = at.attribute("jointinparent");
    if (name == nullptr) {
      ++robot_.ignored["actuator without a joint"];
      return;
    }
    const int found = robot_.find_joint(*name);
    if (found < 0) return read_.report(at, "joint", fmt::format("there is no joint {}", quote_for_message(*name)));
    robot_.joints[static_cast<std::size_t>(found)].is_actuated = robot_.declares_actuators = true;
  }

  const XmlElement& root_;
  const MjcfDefaults& defaults_;
  XmlAttributeReader read_;
  ForeignModel& robot_;
  std::vector<Pose> poses_;
  std::map<std::string, Site> sites_;
  int unnamed_ = 0;
};

}  // namespace

void read_mjcf_relations(const XmlElement& root, const MjcfDefaults& defaults, ForeignDiagnostics& faults,
                         ForeignModel& robot) {
  MjcfRelationReader(root, defaults, faults, robot).run();
}

}  // namespace balance::foreign
