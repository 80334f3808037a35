#include "balance/import/urdf.hpp"

#include "balance/base/extrema.hpp"
#include "balance/base/nearest.hpp"
#include "balance/base/rotation.hpp"
#include "balance/import/element_reader.hpp"
#include "balance/import/read_robot.hpp"
#include "balance/import/urdf_closures.hpp"
#include "balance/import/urdf_relations.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace balance::foreign {

namespace {

bool is_known_name(std::string_view name, std::initializer_list<std::string_view> known) {
  return std::find(known.begin(), known.end(), name) != known.end();
}

class UrdfReader {
 public:
  explicit UrdfReader(const XmlDocument& document) : document_(document), read_(faults_) {}

  ForeignModel run() {
    const XmlElement& root = document_.root;
    if (root.name != "robot") {
      read_.report(root, "", fmt::format("expected <robot>, found <{}>", root.name));
      faults_.throw_if_any();
    }
    const std::string* name = root.attribute("name");
    robot_.name = name == nullptr ? "" : *name;
    robot_.format = "URDF";
    robot_.file = document_.file;
    for (const XmlElement& part : root.children) read_part(part);
    faults_.throw_if_any();
    add_world();
    for (const XmlElement* joint : joints_) read_joint(*joint);
    faults_.throw_if_any();
    read_urdf_mimics(document_.root, faults_, robot_);
    move_root_to_front();
    faults_.throw_if_any();
    read_urdf_closures(document_, robot_);
    read_urdf_transmissions(document_.root, robot_);
    return std::move(robot_);
  }

 private:
  void note(Severity level, const XmlElement& at, std::string code, std::string message) {
    const std::string* name = at.attribute("name");
    robot_.findings.push_back({level, place_of(at), std::move(code),
                               fmt::format("{} {}", at.name, quote_for_message(name == nullptr ? "" : *name)),
                               std::move(message)});
  }

  void read_part(const XmlElement& part) {
    if (part.name.starts_with("xacro:")) {
      read_.report(part, "", "expected a URDF without macros: expand it with xacro first");
    } else if (part.name == "link") {
      read_link(part);
    } else if (part.name == "joint") {
      count(part, joints_.size());
      joints_.push_back(&part);
    } else if (!is_known_name(part.name, {"loop", "constraint", "loop_joint", "coupling", "transmission"})) {
      ++robot_.ignored[part.name];
    }
  }

  /// Checked before names are looked up, which takes time in proportion to their number.
  void count(const XmlElement& at, std::size_t parts) {
    if (parts < max_model_elements) return;
    read_.report(at, "", fmt::format("expected at most {} links and as many joints", max_model_elements));
    faults_.throw_if_any();
  }

  void read_link(const XmlElement& link) {
    count(link, robot_.bodies.size());
    ForeignBody body;
    body.body.name = read_.required_text(link, "name");
    body.place = place_of(link);
    if (!body.body.name.empty() && robot_.find_body(body.body.name) >= 0)
      read_.report(link, "name", "expected another name: there is a link of this one already");
    for (const XmlElement& part : link.children) {
      if (part.name == "inertial" && !body.has_inertial)
        read_inertial(link, part, body);
      else
        ++robot_.ignored[part.name];
      if (part.name == "visual" || part.name == "collision") body.has_geometry = true;
    }
    robot_.bodies.push_back(std::move(body));
  }

  /// Many files hang what stands still on a `world` that they leave to the reader.
  void add_world() {
    const auto hangs_on_it = [](const XmlElement* joint) {
      const XmlElement* parent = joint->child("parent");
      const std::string* link = parent == nullptr ? nullptr : parent->attribute("link");
      return link != nullptr && *link == "world";
    };
    const auto first = std::find_if(joints_.begin(), joints_.end(), hangs_on_it);
    if (first == joints_.end() || robot_.find_body("world") >= 0) return;
    ForeignBody world;
    world.body.name = "world";
    world.place = place_of(**first);
    robot_.bodies.push_back(std::move(world));
    note(Severity::note, **first, "world", "hangs on 'world', which is no link of the file: taken as the ground");
  }

  Pose read_origin(const XmlElement& in) {
    const XmlElement* origin = in.child("origin");
    if (origin == nullptr) return {};
    return {rotation_from_rpy(read_.vector(*origin, "rpy", Vector3::Zero())),
            read_.vector(*origin, "xyz", Vector3::Zero())};
  }

  void read_inertial(const XmlElement& link, const XmlElement& inertial, ForeignBody& body) {
    body.has_inertial = true;
    const Pose pose = read_origin(inertial);
    body.body.com = pose.p;
    const XmlElement* mass = inertial.child("mass");
    if (mass == nullptr || mass->attribute("value") == nullptr)
      return read_.report(inertial, "",
                          fmt::format("expected <mass value=\"…\"/> in link {}", quote_for_message(body.body.name)));
    body.body.mass = read_.number(*mass, "value", 0);
    if (body.body.mass < 0)
      read_.report(
          *mass, "value",
          fmt::format("link {}: expected a mass ≥ 0, found {}", quote_for_message(body.body.name), body.body.mass));
    const XmlElement* inertia = inertial.child("inertia");
    if (inertia == nullptr) {
      note(Severity::warning, link, "no-inertia", "has a mass but no inertia: taken as a point");
      return;
    }
    const auto entry = [&](const char* name) { return read_.number(*inertia, name, 0); };
    Matrix3 I;
    I << entry("ixx"), entry("ixy"), entry("ixz"), entry("ixy"), entry("iyy"), entry("iyz"), entry("ixz"), entry("iyz"),
        entry("izz");
    body.body.inertia = pose.R.isIdentity(0) ? I : Matrix3(pose.R * I * pose.R.transpose());
    body.body.inertia = 0.5 * (body.body.inertia + body.body.inertia.transpose()).eval();
  }

  /// Index of the link that `<parent link="…"/>` names; −1 with a mistake.
  int read_end(const XmlElement& joint, const char* side) {
    const XmlElement* end = joint.child(side);
    const std::string* name = end == nullptr ? nullptr : end->attribute("link");
    if (name == nullptr) {
      read_.report(joint, "", fmt::format("expected <{} link=\"…\"/>", side));
      return -1;
    }
    const int found = robot_.find_body(*name);
    if (found >= 0) return found;
    std::vector<std::string> names;
    for (const ForeignBody& body : robot_.bodies) names.push_back(body.body.name);
    read_.report(*end, "link",
                 fmt::format("joint {}: there is no link {}{}", quote_for_message(*joint.attribute("name")),
                             quote_for_message(*name), append_nearest_name(*name, names)));
    return -1;
  }

  void read_type(const XmlElement& element, ForeignJoint& joint) {
    const std::string type = read_.required_text(element, "type");
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
      read_.report(element, "type",
                   fmt::format("expected revolute, continuous, prismatic, fixed, floating or planar, found {}",
                               quote_for_message(type)));
    if (joint.joint.type == JointType::planar)
      note(Severity::note, element, "planar", "is planar: three coordinates, two slides and an angle");
    if (type == "revolute" && element.child("limit") == nullptr)
      note(Severity::note, element, "no-limit", "is revolute but has no limit: taken as continuous");
  }

  void read_axis(const XmlElement& element, ForeignJoint& joint) {
    if (joint.joint.type == JointType::fixed || joint.joint.type == JointType::spherical) return;
    const XmlElement* said = element.child("axis");
    if (said == nullptr || said->attribute("xyz") == nullptr)
      note(Severity::note, element, "no-axis", "has no axis: (1, 0, 0) is meant");
    const Vector3 axis = said == nullptr ? Vector3::UnitX() : read_.vector(*said, "xyz", Vector3::UnitX());
    const double length = axis.norm();
    if (!(length > 1e-100 && length < 1e100))
      return read_.report(*said, "xyz", "expected a direction, found a vector without length");
    if (std::abs(length - 1) > 1e-6)
      note(Severity::warning, element, "axis",
           fmt::format("its axis ({:.6g}, {:.6g}, {:.6g}) has the length {:.6g}, not 1: normalised", axis.x(), axis.y(),
                       axis.z(), length));
    joint.joint.axis = joint.joint.rotation * axis / length;
    if (joint.joint.type != JointType::planar) return;
    // the same directions of x and y as the spec's default, but said in the parent's axes
    const Vector3 u = joint.joint.axis, away = Vector3::Unit(min_index(joint.joint.axis.cwiseAbs()));
    joint.joint.axis2 = (away - u.dot(away) * u).normalized();
  }

  void read_limits(const XmlElement& element, ForeignJoint& joint) {
    if (const XmlElement* limit = element.child("limit")) {
      const auto given = [&](const char* name) -> std::optional<double> {
        if (limit->attribute(name) == nullptr) return {};
        return read_.number(*limit, name, 0);
      };
      joint.limits = {given("lower"), given("upper"), given("velocity"), given("effort")};
    }
    const XmlElement* dynamics = element.child("dynamics");
    if (dynamics == nullptr) return;
    joint.viscous = read_.number(*dynamics, "damping", 0);
    joint.coulomb = read_.number(*dynamics, "friction", 0);
    if (joint.viscous < 0 || joint.coulomb < 0)
      read_.report(
          *dynamics, "",
          fmt::format("joint {}: damping and friction cannot be negative", quote_for_message(joint.joint.name)));
    if (joint.viscous != 0 || joint.coulomb != 0)
      note(Severity::note, element, "friction",
           fmt::format("damping {:g} and friction {:g} are in 'friction'", joint.viscous, joint.coulomb));
  }

  void read_joint(const XmlElement& element) {
    ForeignJoint joint;
    joint.joint.name = read_.required_text(element, "name");
    joint.place = place_of(element);
    if (joint.joint.name.empty()) return;
    if (robot_.find_joint(joint.joint.name) >= 0)
      read_.report(element, "name", "expected another name: there is a joint of this one already");
    joint.joint.first = read_end(element, "parent");
    joint.joint.second = read_end(element, "child");
    if (joint.joint.first >= 0 && joint.joint.first == joint.joint.second)
      read_.report(element, "", "expected two links, found one: it is its own parent");
    const Pose pose = read_origin(element);
    joint.joint.point_first = pose.p;
    joint.joint.rotation = pose.R;
    if (const XmlElement* origin = element.child("origin"); origin != nullptr && origin->attribute("rpy") != nullptr)
      joint.rpy = read_.vector(*origin, "rpy", Vector3::Zero());
    read_type(element, joint);
    read_axis(element, joint);
    read_limits(element, joint);
    for (const XmlElement& part : element.children)
      if (!is_known_name(part.name, {"origin", "parent", "child", "axis", "limit", "dynamics", "mimic"}))
        ++robot_.ignored[part.name];
    robot_.joints.push_back(std::move(joint));
  }

  /// Whoever is nobody's child.
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
      return read_.report(document_.root, "",
                          roots.empty() ? "expected one root link, found none: every link is some joint's child"
                                        : fmt::format("expected one root link, found {}: {}; join them by fixed joints",
                                                      roots.size(), join_with_conjunction(names, "and")));
    move_to_front(roots.front());
  }

  void move_to_front(int root) {
    const auto place = robot_.bodies.begin() + root;
    std::rotate(robot_.bodies.begin(), place, place + 1);
    const auto moved = [root](BodyId& body) { body = body == root ? ground : body < root ? BodyId(body + 1) : body; };
    for (ForeignJoint& joint : robot_.joints) {
      moved(joint.joint.first);
      moved(joint.joint.second);
    }
  }

  const XmlDocument& document_;
  ForeignDiagnostics faults_;
  XmlAttributeReader read_;
  ForeignModel robot_;
  std::vector<const XmlElement*> joints_;
};

}  // namespace

ForeignModel read_urdf(const XmlDocument& document) { return UrdfReader(document).run(); }

}  // namespace balance::foreign
