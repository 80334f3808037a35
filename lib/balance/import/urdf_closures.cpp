#include "balance/import/urdf_closures.hpp"

#include "balance/base/nearest.hpp"
#include "balance/base/rotation.hpp"
#include "balance/import/closures.hpp"
#include "balance/import/element_reader.hpp"

#include <fmt/format.h>

#include <optional>

namespace balance::foreign {

namespace {

std::string trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r\n");
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(" \t\r\n") - first + 1);
}

class UrdfLoopReader {
 public:
  UrdfLoopReader(const XmlDocument& document, ForeignModel& robot)
      : document_(document), read_(faults_), robot_(robot) {}

  void run() {
    for (const XmlElement& part : document_.root.children) {
      if (part.name == "loop" || part.name == "constraint" || part.name == "loop_joint") read_loop(part);
      if (part.name == "coupling") ++robot_.ignored["coupling"];
      if (part.name != "gazebo") continue;
      for (const XmlElement& joint : part.children)
        if (joint.name == "joint") read_gazebo(joint);
    }
    faults_.throw_if_any();
  }

 private:
  int find_link(const XmlElement& at, const std::string& name) {
    const int found = robot_.find_body(name);
    if (found < 0) read_.report(at, "", fmt::format("there is no link {}", quote_for_message(name)));
    return found;
  }

  Pose pose_in(const XmlElement& at) {
    return {rotation_from_rpy(read_.vector(at, "rpy", Vector3::Zero())), read_.vector(at, "xyz", Vector3::Zero())};
  }

  /// `<predecessor link="a"><origin/></predecessor>` or `<link1 link="a" xyz="" rpy=""/>`.
  std::optional<BodyFrame> read_side(const XmlElement& loop, const char* name, const char* other) {
    const XmlElement* side = loop.child(name);
    if (side == nullptr) side = loop.child(other);
    const std::string* link = side == nullptr ? nullptr : side->attribute("link");
    if (link == nullptr) {
      read_.report(loop, "", fmt::format("expected <{} link=\"…\"/> or <{} link=\"…\"/>", name, other));
      return {};
    }
    const int body = find_link(*side, *link);
    if (body < 0) return {};
    const XmlElement* origin = side->child("origin");
    return BodyFrame{body, pose_in(origin == nullptr ? *side : *origin)};
  }

  std::optional<JointType> read_type(const XmlElement& at) {
    const std::string* given = at.attribute("type");
    const std::string type = given == nullptr ? "" : *given;
    if (type == "revolute" || type == "continuous" || type == "hinge") return JointType::revolute;
    if (type == "prismatic" || type == "slider") return JointType::prismatic;
    if (type == "ball" || type == "spherical" || type == "3d") return JointType::spherical;
    if (type == "fixed" || type == "weld" || type == "6d") return JointType::fixed;
    read_.report(at, "type",
                 fmt::format("expected revolute, prismatic, spherical or fixed, found {}", quote_for_message(type)));
    return {};
  }

  Vector3 direction(const XmlElement& at, const Vector3& axis) {
    const double length = axis.norm();
    if (length > 1e-100 && length < 1e100) return axis / length;
    read_.report(at, "", "expected an axis, found a vector without length");
    return Vector3::UnitX();
  }

  std::string name_of(const XmlElement& at) {
    const std::string* name = at.attribute("name");
    return name != nullptr && !name->empty() ? *name : fmt::format("loop{}", ++unnamed_);
  }

  void read_loop(const XmlElement& loop) {
    const auto type = read_type(loop);
    const auto first = read_side(loop, "predecessor", "link1"), second = read_side(loop, "successor", "link2");
    const XmlElement* axis = loop.child("axis");
    const Vector3 u =
        axis == nullptr ? Vector3(Vector3::UnitX()) : direction(*axis, read_.vector(*axis, "xyz", Vector3::UnitX()));
    if (!type || !first || !second) return;
    BodyFrame before = *first;
    // one origin of the loop itself is the frame in the predecessor
    if (const XmlElement* origin = loop.child("origin")) before.pose = pose_in(*origin);
    if (first->body == second->body) return read_.report(loop, "", "expected two links, found one");
    add_loop_joint(robot_, name_of(loop), *type, before, *second, u, place_of(loop));
  }

  /// SDF's way: names as text; the pose is in the child's frame, the axis in the joint's; the parent's frame follows from the model.
  void read_gazebo(const XmlElement& joint) {
    const auto type = read_type(joint);
    const XmlElement *parent = joint.child("parent"), *child = joint.child("child"), *pose = joint.child("pose");
    if (parent == nullptr || child == nullptr) return read_.report(joint, "", "expected <parent> and <child>");
    const int first = find_link(*parent, trimmed(parent->text)), second = find_link(*child, trimmed(child->text));
    if (!type || first < 0 || second < 0) return;
    if (first == second) return read_.report(joint, "", "expected two links, found one");
    Pose in_child;
    if (pose != nullptr) {
      const auto v = parse_number_list(pose->text);
      if (!v || v->size() != 6) return read_.report(*pose, "", "expected 6 numbers: x y z roll pitch yaw");
      in_child = {rotation_from_rpy({(*v)[3], (*v)[4], (*v)[5]}), {(*v)[0], (*v)[1], (*v)[2]}};
    }
    Vector3 u = Vector3::UnitZ();
    const XmlElement* axis = joint.child("axis");
    if (const XmlElement* xyz = axis == nullptr ? nullptr : axis->child("xyz")) {
      const auto v = parse_number_list(xyz->text);
      if (!v || v->size() != 3) return read_.report(*xyz, "", "expected 3 numbers");
      u = direction(*xyz, {(*v)[0], (*v)[1], (*v)[2]});
    }
    if (poses_.empty()) poses_ = zero_configuration_poses(robot_);  // of the tree: closures do not change it
    const Pose in_parent =
        poses_[static_cast<std::size_t>(first)].inverse() * poses_[static_cast<std::size_t>(second)] * in_child;
    add_loop_joint(robot_, name_of(joint), *type, {first, in_parent}, {second, in_child}, u, place_of(joint));
  }

  const XmlDocument& document_;
  ForeignDiagnostics faults_;
  XmlAttributeReader read_;
  ForeignModel& robot_;
  std::vector<Pose> poses_;
  int unnamed_ = 0;
};

}  // namespace

void read_urdf_closures(const XmlDocument& document, ForeignModel& robot) { UrdfLoopReader(document, robot).run(); }

}  // namespace balance::foreign
