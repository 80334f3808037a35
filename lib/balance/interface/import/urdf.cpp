#include "balance/foundation/base/rotation.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/base/unicode_text.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/interface/import/foreign_model.hpp"
#include "balance/interface/import/foreign_readers.hpp"
#include "balance/interface/import/xml_document.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>

namespace balance::foreign {

// Loop closures inside a URDF.

/// Reads `<loop>` and `<constraint>` with `<predecessor link>` and `<successor link>`, `<loop_joint>` with `<link1>`
/// and `<link2>`, and `<joint>` inside `<gazebo>`, whose frames follow from the model's zero pose.
/// @throws SpecError listing everything that is wrong with them
void read_urdf_closures(const XmlDocument& document, ForeignModel& robot);

// Further properties of joints in a URDF.

/// Turns each `<mimic>` into a coupling.
/// @pre the robot has all joints
void read_urdf_mimics(const XmlElement& root, ForeignDiagnostics& diagnostics, ForeignModel& robot);

/// Marks the joints that a `<transmission>` names as actuated.
void read_urdf_transmissions(const XmlElement& root, ForeignModel& robot);

namespace {

class UrdfReader {
 public:
  explicit UrdfReader(const XmlDocument& document) : document_(document), reader_(diagnostics_) {}

  ForeignModel run() {
    const XmlElement& root = document_.root;
    if (root.name != "robot") {
      reader_.report(root, "", fmt::format("expected <robot>, found <{}>", root.name));
      diagnostics_.throw_if_any();
    }
    const std::string* name = root.attribute("name");
    robot_.name = name == nullptr ? "" : *name;
    robot_.format = "URDF";
    robot_.file = document_.file;
    for (const XmlElement& element : root.children) read_element(element);
    diagnostics_.throw_if_any();
    add_world();
    for (const XmlElement* joint : joints_) read_joint(*joint);
    diagnostics_.throw_if_any();
    read_urdf_mimics(document_.root, diagnostics_, robot_);
    move_root_to_front();
    diagnostics_.throw_if_any();
    read_urdf_closures(document_, robot_);
    read_urdf_transmissions(document_.root, robot_);
    return std::move(robot_);
  }

 private:
  void add_finding(Severity level, const XmlElement& at, std::string code, std::string message) {
    const std::string* name = at.attribute("name");
    robot_.findings.push_back({level, place_of(at), std::move(code),
                               fmt::format("{} {}", at.name, quote_for_message(name == nullptr ? "" : *name)),
                               std::move(message)});
  }

  void read_element(const XmlElement& element) {
    if (element.name.starts_with("xacro:")) {
      reader_.report(element, "", "expected a URDF without macros: expand it with xacro first");
    } else if (element.name == "link") {
      read_link(element);
    } else if (element.name == "joint") {
      check_count(element, joints_.size());
      joints_.push_back(&element);
    } else if (!is_one_of(element.name, {"loop", "constraint", "loop_joint", "coupling", "transmission"})) {
      ++robot_.ignored[element.name];
    }
  }

  /// Checks the number of elements before names are looked up, which takes time proportional to it.
  void check_count(const XmlElement& at, std::size_t count) {
    if (count < max_model_elements) return;
    reader_.report(at, "", fmt::format("expected at most {} links and as many joints", max_model_elements));
    diagnostics_.throw_if_any();
  }

  void read_link(const XmlElement& link) {
    check_count(link, robot_.bodies.size());
    ForeignBody body;
    body.body.name = reader_.required_text(link, "name");
    body.place = place_of(link);
    if (!body.body.name.empty() && robot_.find_body(body.body.name) >= 0)
      reader_.report(link, "name", "expected a unique name: another link has this one");
    for (const XmlElement& child : link.children) {
      if (child.name == "inertial" && !body.has_inertial)
        read_inertial(link, child, body);
      else
        ++robot_.ignored[child.name];
      if (child.name == "visual" || child.name == "collision") body.has_geometry = true;
    }
    robot_.bodies.push_back(std::move(body));
  }

  /// Many files attach fixed parts to a `world` that they do not define.
  void add_world() {
    const auto is_child_of_world = [](const XmlElement* joint) {
      const XmlElement* parent = joint->child("parent");
      const std::string* link = parent == nullptr ? nullptr : parent->attribute("link");
      return link != nullptr && *link == "world";
    };
    const auto first = std::find_if(joints_.begin(), joints_.end(), is_child_of_world);
    if (first == joints_.end() || robot_.find_body("world") >= 0) return;
    ForeignBody world;
    world.body.name = "world";
    world.place = place_of(**first);
    robot_.bodies.push_back(std::move(world));
    add_finding(Severity::note, **first, "world",
                "is attached to 'world', which is not a link of the file: taken as the ground");
  }

  Pose read_origin(const XmlElement& parent) {
    const XmlElement* origin = parent.child("origin");
    if (origin == nullptr) return {};
    return {rotation_from_rpy(reader_.vector(*origin, "rpy", Vector3::Zero())),
            reader_.vector(*origin, "xyz", Vector3::Zero())};
  }

  void read_inertial(const XmlElement& link, const XmlElement& inertial, ForeignBody& body) {
    body.has_inertial = true;
    const Pose pose = read_origin(inertial);
    body.body.com = pose.p;
    const XmlElement* mass = inertial.child("mass");
    if (mass == nullptr || mass->attribute("value") == nullptr)
      return reader_.report(inertial, "",
                            fmt::format("expected <mass value=\"…\"/> in link {}", quote_for_message(body.body.name)));
    body.body.mass = reader_.number(*mass, "value", 0);
    if (body.body.mass < 0)
      reader_.report(
          *mass, "value",
          fmt::format("link {}: expected a mass ≥ 0, found {}", quote_for_message(body.body.name), body.body.mass));
    const XmlElement* inertia = inertial.child("inertia");
    if (inertia == nullptr) {
      add_finding(Severity::warning, link, "no-inertia", "has a mass but no inertia: taken as a point");
      return;
    }
    const auto entry = [&](const char* name) { return reader_.number(*inertia, name, 0); };
    Matrix3 I;
    I << entry("ixx"), entry("ixy"), entry("ixz"), entry("ixy"), entry("iyy"), entry("iyz"), entry("ixz"), entry("iyz"),
        entry("izz");
    body.body.inertia = pose.R.isIdentity(0) ? I : Matrix3(pose.R * I * pose.R.transpose());
    body.body.inertia = 0.5 * (body.body.inertia + body.body.inertia.transpose()).eval();
  }

  /// Index of the link that `<parent link="…"/>` or `<child link="…"/>` names; −1 after reporting a mistake.
  int read_end(const XmlElement& joint, const char* side) {
    const XmlElement* end_element = joint.child(side);
    const std::string* name = end_element == nullptr ? nullptr : end_element->attribute("link");
    if (name == nullptr) {
      reader_.report(joint, "", fmt::format("expected <{} link=\"…\"/>", side));
      return -1;
    }
    const int link_index = robot_.find_body(*name);
    if (link_index >= 0) return link_index;
    std::vector<std::string> names;
    for (const ForeignBody& body : robot_.bodies) names.push_back(body.body.name);
    reader_.report(*end_element, "link",
                   fmt::format("joint {}: there is no link {}{}", quote_for_message(*joint.attribute("name")),
                               quote_for_message(*name), append_nearest_name(*name, names)));
    return -1;
  }

  void read_type(const XmlElement& element, ForeignJoint& joint) {
    const std::string type = reader_.required_text(element, "type");
    if (type == "revolute" || type == "continuous")
      joint.joint.type = JointType::revolute;
    else if (type == "prismatic")
      joint.joint.type = JointType::prismatic;
    else if (type == "fixed")
      joint.joint.type = JointType::fixed;
    else if (type == "planar")
      joint.joint.type = JointType::planar;
    else if (type == "spherical" || type == "ball")
      joint.joint.type = JointType::spherical;
    else if (type == "floating") {
      joint.joint.type = JointType::fixed;
      joint.is_floating = true;
    } else if (!type.empty())
      reader_.report(element, "type",
                     fmt::format("expected revolute, continuous, prismatic, fixed, floating or planar, found {}",
                                 quote_for_message(type)));
    if (joint.joint.type == JointType::planar)
      add_finding(Severity::note, element, "planar", "is planar: three coordinates, two slides and an angle");
    if (type == "revolute" && element.child("limit") == nullptr)
      add_finding(Severity::note, element, "no-limit", "is revolute but has no limit: taken as continuous");
  }

  void read_axis(const XmlElement& element, ForeignJoint& joint) {
    if (joint.joint.type == JointType::fixed || joint.joint.type == JointType::spherical) return;
    const XmlElement* axis_element = element.child("axis");
    if (axis_element == nullptr || axis_element->attribute("xyz") == nullptr)
      add_finding(Severity::note, element, "no-axis", "has no axis: (1, 0, 0) is assumed");
    const Vector3 axis =
        axis_element == nullptr ? Vector3::UnitX() : reader_.vector(*axis_element, "xyz", Vector3::UnitX());
    const double length = axis.norm();
    if (!(length > 1e-100 && length < 1e100))
      return reader_.report(*axis_element, "xyz", "expected a direction, found a zero vector");
    if (std::abs(length - 1) > 1e-6)
      add_finding(Severity::warning, element, "axis",
                  fmt::format("its axis ({:.6g}, {:.6g}, {:.6g}) has the length {:.6g}, not 1: normalised", axis.x(),
                              axis.y(), axis.z(), length));
    joint.joint.axis = joint.joint.rotation * axis / length;
    if (joint.joint.type != JointType::planar) return;
    // the same directions of x and y as the spec's default, but in the parent's axes
    const Vector3 u = joint.joint.axis, reference = Vector3::Unit(numerics::min_index(joint.joint.axis.cwiseAbs()));
    joint.joint.axis2 = (reference - u.dot(reference) * u).normalized();
  }

  void read_limits(const XmlElement& element, ForeignJoint& joint) {
    if (const XmlElement* limit = element.child("limit")) {
      const auto optional_number = [&](const char* name) -> std::optional<double> {
        if (limit->attribute(name) == nullptr) return {};
        return reader_.number(*limit, name, 0);
      };
      joint.limits = {optional_number("lower"), optional_number("upper"), optional_number("velocity"),
                      optional_number("effort")};
    }
    const XmlElement* dynamics = element.child("dynamics");
    if (dynamics == nullptr) return;
    joint.viscous = reader_.number(*dynamics, "damping", 0);
    joint.coulomb = reader_.number(*dynamics, "friction", 0);
    if (joint.viscous < 0 || joint.coulomb < 0)
      reader_.report(
          *dynamics, "",
          fmt::format("joint {}: damping and friction cannot be negative", quote_for_message(joint.joint.name)));
    if (joint.viscous != 0 || joint.coulomb != 0)
      add_finding(Severity::note, element, "friction",
                  fmt::format("damping {:g} and friction {:g} are in 'friction'", joint.viscous, joint.coulomb));
  }

  void read_joint(const XmlElement& element) {
    ForeignJoint joint;
    joint.joint.name = reader_.required_text(element, "name");
    joint.place = place_of(element);
    if (joint.joint.name.empty()) return;
    if (robot_.find_joint(joint.joint.name) >= 0)
      reader_.report(element, "name", "expected a unique name: another joint has this one");
    joint.joint.first = read_end(element, "parent");
    joint.joint.second = read_end(element, "child");
    if (joint.joint.first >= 0 && joint.joint.first == joint.joint.second)
      reader_.report(element, "", "expected two links, found one: it is its own parent");
    const Pose pose = read_origin(element);
    joint.joint.point_first = pose.p;
    joint.joint.rotation = pose.R;
    if (const XmlElement* origin = element.child("origin"); origin != nullptr && origin->attribute("rpy") != nullptr)
      joint.rpy = reader_.vector(*origin, "rpy", Vector3::Zero());
    read_type(element, joint);
    read_axis(element, joint);
    read_limits(element, joint);
    for (const XmlElement& child : element.children)
      if (!is_one_of(child.name, {"origin", "parent", "child", "axis", "limit", "dynamics", "mimic"}))
        ++robot_.ignored[child.name];
    robot_.joints.push_back(std::move(joint));
  }

  /// The root is the only link that is no joint's child.
  void move_root_to_front() {
    std::set<int> children;
    for (const ForeignJoint& joint : robot_.joints) children.insert(joint.joint.second);
    std::vector<int> roots;
    for (int b = 0; b < static_cast<int>(robot_.bodies.size()); ++b)
      if (children.count(b) == 0) roots.push_back(b);
    std::vector<std::string> names;
    for (const int root : roots)
      names.push_back(quote_for_message(robot_.bodies[static_cast<std::size_t>(root)].body.name));
    if (roots.size() != 1)
      return reader_.report(document_.root, "",
                            roots.empty()
                                ? "expected one root link, found none: every link is some joint's child"
                                : fmt::format("expected one root link, found {}: {}; join them by fixed joints",
                                              roots.size(), join_with_conjunction(names, "and")));
    move_to_front(roots.front());
  }

  void move_to_front(int root) {
    const auto root_position = robot_.bodies.begin() + root;
    std::rotate(robot_.bodies.begin(), root_position, root_position + 1);
    const auto shift_index = [root](BodyId& body) {
      body = body == root ? model::ground : body < root ? BodyId(body + 1) : body;
    };
    for (ForeignJoint& joint : robot_.joints) {
      shift_index(joint.joint.first);
      shift_index(joint.joint.second);
    }
  }

  const XmlDocument& document_;
  ForeignDiagnostics diagnostics_;
  XmlAttributeReader reader_;
  ForeignModel robot_;
  std::vector<const XmlElement*> joints_;
};

}  // namespace

ForeignModel read_urdf(const XmlDocument& document) { return UrdfReader(document).run(); }

namespace {

class UrdfLoopReader {
 public:
  UrdfLoopReader(const XmlDocument& document, ForeignModel& robot)
      : document_(document), reader_(diagnostics_), robot_(robot) {}

  void run() {
    for (const XmlElement& element : document_.root.children) {
      if (element.name == "loop" || element.name == "constraint" || element.name == "loop_joint") read_loop(element);
      if (element.name == "coupling") ++robot_.ignored["coupling"];
      if (element.name != "gazebo") continue;
      for (const XmlElement& joint : element.children)
        if (joint.name == "joint") read_gazebo(joint);
    }
    diagnostics_.throw_if_any();
  }

 private:
  int find_link(const XmlElement& at, const std::string& name) {
    const int body = robot_.find_body(name);
    if (body < 0) reader_.report(at, "", fmt::format("there is no link {}", quote_for_message(name)));
    return body;
  }

  Pose read_pose(const XmlElement& at) {
    return {rotation_from_rpy(reader_.vector(at, "rpy", Vector3::Zero())), reader_.vector(at, "xyz", Vector3::Zero())};
  }

  /// `<predecessor link="a"><origin/></predecessor>` or `<link1 link="a" xyz="" rpy=""/>`.
  std::optional<BodyFrame> read_side(const XmlElement& loop, const char* name, const char* alternative) {
    const XmlElement* side = loop.child(name);
    if (side == nullptr) side = loop.child(alternative);
    const std::string* link = side == nullptr ? nullptr : side->attribute("link");
    if (link == nullptr) {
      reader_.report(loop, "", fmt::format("expected <{} link=\"…\"/> or <{} link=\"…\"/>", name, alternative));
      return {};
    }
    const int body = find_link(*side, *link);
    if (body < 0) return {};
    const XmlElement* origin = side->child("origin");
    return BodyFrame{body, read_pose(origin == nullptr ? *side : *origin)};
  }

  std::optional<JointType> read_type(const XmlElement& at) {
    const std::string* type_attribute = at.attribute("type");
    const std::string type = type_attribute == nullptr ? "" : *type_attribute;
    if (type == "revolute" || type == "continuous" || type == "hinge") return JointType::revolute;
    if (type == "prismatic" || type == "slider") return JointType::prismatic;
    if (type == "ball" || type == "spherical" || type == "3d") return JointType::spherical;
    if (type == "fixed" || type == "weld" || type == "6d") return JointType::fixed;
    reader_.report(at, "type",
                   fmt::format("expected revolute, prismatic, spherical or fixed, found {}", quote_for_message(type)));
    return {};
  }

  Vector3 normalize_axis(const XmlElement& at, const Vector3& axis) {
    const double length = axis.norm();
    if (length > 1e-100 && length < 1e100) return axis / length;
    reader_.report(at, "", "expected an axis, found a zero vector");
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
    const Vector3 u = axis == nullptr ? Vector3(Vector3::UnitX())
                                      : normalize_axis(*axis, reader_.vector(*axis, "xyz", Vector3::UnitX()));
    if (!type || !first || !second) return;
    BodyFrame first_frame = *first;
    // an origin of the loop itself is the frame in the predecessor
    if (const XmlElement* origin = loop.child("origin")) first_frame.pose = read_pose(*origin);
    if (first->body == second->body) return reader_.report(loop, "", "expected two links, found one");
    add_loop_joint(robot_, name_of(loop), *type, first_frame, *second, u, place_of(loop));
  }

  /// SDF syntax: names as text; the pose is in the child's frame, the axis in the joint's. The parent's frame follows
  /// from the model's zero pose.
  void read_gazebo(const XmlElement& joint) {
    const auto type = read_type(joint);
    const XmlElement *parent = joint.child("parent"), *child = joint.child("child"), *pose = joint.child("pose");
    if (parent == nullptr || child == nullptr) return reader_.report(joint, "", "expected <parent> and <child>");
    const int first = find_link(*parent, std::string(trim(parent->text))),
              second = find_link(*child, std::string(trim(child->text)));
    if (!type || first < 0 || second < 0) return;
    if (first == second) return reader_.report(joint, "", "expected two links, found one");
    Pose child_pose;
    if (pose != nullptr) {
      const auto v = parse_number_list(pose->text);
      if (!v || v->size() != 6) return reader_.report(*pose, "", "expected 6 numbers: x y z roll pitch yaw");
      child_pose = {rotation_from_rpy({(*v)[3], (*v)[4], (*v)[5]}), {(*v)[0], (*v)[1], (*v)[2]}};
    }
    Vector3 u = Vector3::UnitZ();
    const XmlElement* axis = joint.child("axis");
    if (const XmlElement* xyz = axis == nullptr ? nullptr : axis->child("xyz")) {
      const auto v = parse_number_list(xyz->text);
      if (!v || v->size() != 3) return reader_.report(*xyz, "", "expected 3 numbers");
      u = normalize_axis(*xyz, {(*v)[0], (*v)[1], (*v)[2]});
    }
    if (poses_.empty()) poses_ = zero_configuration_poses(robot_);  // of the tree: closures do not affect it
    const Pose parent_pose =
        poses_[static_cast<std::size_t>(first)].inverse() * poses_[static_cast<std::size_t>(second)] * child_pose;
    add_loop_joint(robot_, name_of(joint), *type, {first, parent_pose}, {second, child_pose}, u, place_of(joint));
  }

  const XmlDocument& document_;
  ForeignDiagnostics diagnostics_;
  XmlAttributeReader reader_;
  ForeignModel& robot_;
  std::vector<Pose> poses_;
  int unnamed_ = 0;
};

}  // namespace

void read_urdf_closures(const XmlDocument& document, ForeignModel& robot) { UrdfLoopReader(document, robot).run(); }

namespace {

bool has_one_coordinate(const ForeignModel& robot, int joint) {
  return joint >= 0 && joint_degrees_of_freedom(robot.joints[static_cast<std::size_t>(joint)].joint.type) == 1;
}

/// Locks a joint that mimics with the factor 0 at its offset.
void lock_joint(ForeignJoint& foreign_joint, double offset) {
  Joint& joint = foreign_joint.joint;
  if (joint.type == JointType::prismatic)
    joint.point_first += offset * joint.axis;
  else
    joint.rotation = rotation_about(joint.axis, offset) * joint.rotation;
  joint.type = JointType::fixed;
  foreign_joint.rpy.reset();
  foreign_joint.viscous = foreign_joint.coulomb = foreign_joint.stiffness = 0;
}

std::string format_leader_error(const ForeignModel& robot, const ForeignCoupling& coupling) {
  if (coupling.leader < 0) return ", which is not a joint here";
  if (coupling.leader == coupling.follower) return ", which is this joint itself";
  const int count = joint_degrees_of_freedom(robot.joints[static_cast<std::size_t>(coupling.leader)].joint.type);
  return count == 0 ? ", which is fixed" : fmt::format(", which has {} coordinates", count);
}

void read_mimic(const XmlElement& element, const XmlElement& mimic, const XmlAttributeReader& reader,
                ForeignModel& robot) {
  ForeignCoupling coupling;
  coupling.place = place_of(mimic);
  coupling.follower = robot.find_joint(*element.attribute("name"));
  const std::string leader = reader.required_text(mimic, "joint");
  coupling.leader = robot.find_joint(leader);
  coupling.ratio = reader.number(mimic, "multiplier", 1);
  coupling.offset = reader.number(mimic, "offset", 0);
  if (leader.empty()) return;
  const std::string subject = fmt::format("joint {}", quote_for_message(*element.attribute("name")));
  if (coupling.follower >= 0 &&
      joint_degrees_of_freedom(robot.joints[static_cast<std::size_t>(coupling.follower)].joint.type) == 0) {
    robot.findings.push_back({Severity::note, place_of(element), "mimic", subject,
                              fmt::format("is fixed and mimics {}: this has no effect", quote_for_message(leader))});
    return;
  }
  if (!has_one_coordinate(robot, coupling.leader) || coupling.leader == coupling.follower)
    return reader.report(mimic, "joint",
                         fmt::format("expected another joint with one coordinate, found {}{}",
                                     quote_for_message(leader), format_leader_error(robot, coupling)));
  if (!has_one_coordinate(robot, coupling.follower))
    return reader.report(mimic, "", "only a joint with one coordinate can mimic");
  if (coupling.ratio == 0) {
    lock_joint(robot.joints[static_cast<std::size_t>(coupling.follower)], coupling.offset);
    robot.findings.push_back(
        {Severity::warning, place_of(element), "mimic", subject,
         fmt::format("mimics {} with the factor 0: held at {:g}", quote_for_message(leader), coupling.offset)});
    return;
  }
  robot.findings.push_back({Severity::note, place_of(element), "mimic", subject,
                            fmt::format("mimics {}: a coupling, ratio {:g}, offset {:g}", quote_for_message(leader),
                                        coupling.ratio, coupling.offset)});
  robot.couplings.push_back(std::move(coupling));
}

}  // namespace

void read_urdf_mimics(const XmlElement& root, ForeignDiagnostics& diagnostics, ForeignModel& robot) {
  const XmlAttributeReader reader(diagnostics);
  for (const XmlElement& element : root.children)
    if (const XmlElement* mimic = element.name == "joint" ? element.child("mimic") : nullptr)
      read_mimic(element, *mimic, reader, robot);
}

void read_urdf_transmissions(const XmlElement& root, ForeignModel& robot) {
  for (const XmlElement& element : root.children) {
    if (element.name != "transmission") continue;
    bool names_joint = false;
    for (const XmlElement& joint : element.children) {
      const std::string* name = joint.name == "joint" ? joint.attribute("name") : nullptr;
      const int joint_index = name == nullptr ? -1 : robot.find_joint(*name);
      if (joint_index < 0 ||
          joint_degrees_of_freedom(robot.joints[static_cast<std::size_t>(joint_index)].joint.type) == 0)
        continue;
      robot.joints[static_cast<std::size_t>(joint_index)].is_actuated = robot.declares_actuators = names_joint = true;
    }
    if (!names_joint) ++robot.ignored[element.name];
  }
}

}  // namespace balance::foreign
