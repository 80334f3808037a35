// MJCF: the file stands at the reference pose, where qpos are the spec's coordinates (`ref`), so that MuJoCo finds the
// points that close loops. A joint's place and axis are given in its body's frame at that pose.

#include "balance/foundation/base/rotation.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/import/robot_xml.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace balance::foreign {

namespace {

/// Equality constraints as stiff as MuJoCo's default time step of 2 ms allows.
constexpr const char* closure_solref = "0.004 1";
constexpr const char* closure_solimp = "0.999 0.9999 0.001";

/// Radii of the drawn shapes in characteristic lengths.
constexpr double rod_radius = 0.015, weight_radius = 0.04;

class MjcfWriter {
 public:
  MjcfWriter(const RobotTree& tree, RobotExport& out) : tree_(tree), out_(out), children_(tree.links.size()) {
    for (std::size_t l = 0; l < tree.links.size(); ++l) {
      const int parent = tree.links[l].parent;
      (parent == ground_link ? roots_ : children_[static_cast<std::size_t>(parent)]).push_back(l);
      names_.push_back(body_names_.add(tree.links[l].name));
    }
  }

  void run() {
    pugi::xml_document document;
    pugi::xml_node root = document.append_child("mujoco");
    root.append_attribute("model") = tree_.name.c_str();
    pugi::xml_node settings = root.append_child("compiler");
    set_attribute(settings, "angle", "radian");
    set_attribute(settings, "inertiafromgeom", "false");
    set_attribute(root.append_child("option"), "gravity", format_xml_numbers(tree_.gravity));
    pugi::xml_node geom = root.append_child("default").append_child("geom");
    set_attribute(geom, "contype", "0");
    set_attribute(geom, "conaffinity", "0");
    pugi::xml_node world = root.append_child("worldbody");
    set_attribute(world.append_child("light"), "pos", format_xml_numbers(Vector3(0, 0, 4 * tree_.length)));
    for (std::size_t s = 0; s < tree_.springs.size(); ++s) add_sites(world, s, ground_link);
    for (const std::size_t root_link : roots_) add_body(world, root_link);
    add_tendons(root);
    add_equalities(root);
    add_motors(root);
    add_keyframe(root);
    add_comments(root);
    out_.text = format_xml(document);
  }

 private:
  static std::string quaternion(const Matrix3& R) {
    const Eigen::Vector4d q = quaternion_of(R);
    return fmt::format("{} {} {} {}", q[0] + 0.0, q[1] + 0.0, q[2] + 0.0, q[3] + 0.0);
  }

  const RobotLink& link(int index) const { return tree_.links[static_cast<std::size_t>(index)]; }
  Pose pose_of(int index) const { return index == ground_link ? Pose{} : link(index).pose; }
  std::string name_of_link(int index) const {
    return index == ground_link ? "world" : names_[static_cast<std::size_t>(index)];
  }

  void add_body(pugi::xml_node parent, std::size_t l) {
    const RobotLink& one = tree_.links[l];
    const Pose relative = pose_of(one.parent).inverse() * one.pose;
    pugi::xml_node body = parent.append_child("body");
    set_attribute(body, "name", names_[l]);
    set_attribute(body, "pos", format_xml_numbers(relative.p));
    if (!relative.R.isIdentity(0)) set_attribute(body, "quat", quaternion(relative.R));
    if (!one.attachments.empty())
      body.append_child(pugi::node_comment)
          .set_value(fmt::format(" with {} ", fmt::join(one.attachments, ", ")).c_str());
    for (const RobotJoint& joint : one.joints) add_joint(body, joint, one);
    if (!one.joints.empty() || one.mass > 0) add_inertial(body, one);
    add_shapes(body, l);
    for (std::size_t s = 0; s < tree_.springs.size(); ++s) add_sites(body, s, static_cast<int>(l));
    for (const std::size_t child : children_[l]) add_body(body, child);
  }

  void add_joint(pugi::xml_node body, const RobotJoint& joint, const RobotLink& one) {
    pugi::xml_node node = body.append_child("joint");
    set_attribute(node, "name", joint.name);
    set_attribute(node, "type", joint.is_rotation ? "hinge" : "slide");
    const Pose to_link = one.pose.inverse();
    if (joint.is_rotation) set_attribute(node, "pos", format_xml_numbers(to_link.p + to_link.R * joint.anchor));
    set_attribute(node, "axis", format_xml_numbers(to_link.R * joint.axis));
    if (joint.reference != 0) set_attribute(node, "ref", joint.reference);
    if (joint.viscous != 0) set_attribute(node, "damping", joint.viscous);
    if (joint.coulomb != 0) set_attribute(node, "frictionloss", joint.coulomb);
    if (joint.stiffness != 0) {
      set_attribute(node, "stiffness", joint.stiffness);
      set_attribute(node, "springref", joint.preload / joint.stiffness);
    } else if (joint.preload != 0) {
      out_.missing.push_back(
          fmt::format("the constant effort on {}, of a spring without stiffness", quote_for_message(joint.name)));
    }
    start_.push_back(joint.start);
  }

  static void add_inertial(pugi::xml_node body, const RobotLink& one) {
    const XmlInertia inertia = make_xml_inertia(one);
    pugi::xml_node node = body.append_child("inertial");
    set_attribute(node, "pos", format_xml_numbers(inertia.com));
    if (!inertia.axes.isIdentity(0)) set_attribute(node, "quat", quaternion(inertia.axes));
    set_attribute(node, "mass", inertia.mass);
    set_attribute(node, "diaginertia", format_xml_numbers(inertia.moments));
  }

  /// Rods from the body's own joint to those of its children, and balls at centres of mass of what it carries: for the
  /// eye alone.
  void add_shapes(pugi::xml_node body, std::size_t l) {
    const RobotLink& one = tree_.links[l];
    const Pose to_link = one.pose.inverse();
    const auto place = [&](const Vector3& point) { return Vector3(to_link.p + to_link.R * point); };
    const Vector3 own = one.joints.empty() ? Vector3(Vector3::Zero()) : place(one.joints.back().anchor);
    std::vector<Vector3> ends;
    for (const std::size_t child : children_[l])
      if (!tree_.links[child].joints.empty()) ends.push_back(place(tree_.links[child].joints.front().anchor));
    for (const RobotClosure& closure : tree_.closures)
      if (closure.first == static_cast<int>(l) || closure.second == static_cast<int>(l))
        ends.push_back(place(closure.anchor));
    if (ends.empty()) ends.push_back(one.com);
    for (const Vector3& end : ends) {
      if (!((end - own).norm() > rod_radius * tree_.length)) continue;
      pugi::xml_node geom = body.append_child("geom");
      set_attribute(geom, "type", "capsule");
      set_attribute(geom, "fromto", format_xml_numbers(own) + " " + format_xml_numbers(end));
      set_attribute(geom, "size", rod_radius * tree_.length);
    }
    if (one.attachments.empty()) return;
    pugi::xml_node geom = body.append_child("geom");
    set_attribute(geom, "type", "sphere");
    set_attribute(geom, "pos", format_xml_numbers(one.com));
    set_attribute(geom, "size", weight_radius * tree_.length);
  }

  std::string site_name(std::size_t s, bool is_first) {
    return fmt::format("{} {}", spring_name(s), is_first ? "first" : "second");
  }

  /// Springs of one name, a spring and a damper, get different ones.
  const std::string& spring_name(std::size_t s) {
    if (spring_names_.empty())
      for (const RobotSpring& spring : tree_.springs) spring_names_.push_back(tendon_names_.add(spring.name));
    return spring_names_[s];
  }

  void add_sites(pugi::xml_node body, std::size_t s, int l) {
    const RobotSpring& spring = tree_.springs[s];
    const auto add = [&](const Vector3& point, bool is_first) {
      pugi::xml_node site = body.append_child("site");
      set_attribute(site, "name", site_name(s, is_first));
      set_attribute(site, "pos", format_xml_numbers(point));
      set_attribute(site, "size", rod_radius * tree_.length);
    };
    if (spring.first == l) add(spring.point_first, true);
    if (spring.second == l) add(spring.point_second, false);
  }

  /// Springs between points, and sums of coordinates that a coordinate follows.
  void add_tendons(pugi::xml_node root) {
    pugi::xml_node tendons = root.append_child("tendon");
    for (std::size_t s = 0; s < tree_.springs.size(); ++s) {
      const RobotSpring& spring = tree_.springs[s];
      pugi::xml_node node = tendons.append_child("spatial");
      set_attribute(node, "name", spring_name(s));
      set_attribute(node, "width", 0.5 * rod_radius * tree_.length);
      if (spring.stiffness != 0) {
        set_attribute(node, "stiffness", spring.stiffness);
        set_attribute(node, "springlength", spring.free_length);
      }
      if (spring.damping != 0) set_attribute(node, "damping", spring.damping);
      set_attribute(node.append_child("site"), "site", site_name(s, true));
      set_attribute(node.append_child("site"), "site", site_name(s, false));
    }
    for (const RobotCoupling& coupling : tree_.couplings) {
      if (coupling.leaders.size() == 1) continue;
      pugi::xml_node node = tendons.append_child("fixed");
      belts_[coupling.joint] = tendon_names_.add(coupling.joint);
      set_attribute(node, "name", belts_[coupling.joint]);
      const auto add = [&](const std::string& joint, double coefficient) {
        pugi::xml_node term = node.append_child("joint");
        set_attribute(term, "joint", joint);
        set_attribute(term, "coef", coefficient);
      };
      add(coupling.joint, 1);
      for (const auto& [leader, ratio] : coupling.leaders) add(leader, -ratio);
    }
    if (!tendons.first_child()) root.remove_child(tendons);
  }

  double reference_of(const std::string& name) const {
    for (const RobotLink& one : tree_.links)
      for (const RobotJoint& joint : one.joints)
        if (joint.name == name) return joint.reference;
    return 0;
  }

  /// MuJoCo counts both sides of a coupling from the reference pose.
  void add_coupling(pugi::xml_node equalities, const RobotCoupling& coupling) {
    double offset = coupling.offset - reference_of(coupling.joint);
    for (const auto& [leader, ratio] : coupling.leaders) offset += ratio * reference_of(leader);
    const bool is_belt = coupling.leaders.size() != 1;
    pugi::xml_node node = equalities.append_child(is_belt ? "tendon" : "joint");
    set_attribute(node, is_belt ? "tendon1" : "joint1", is_belt ? belts_[coupling.joint] : coupling.joint);
    if (!is_belt) set_attribute(node, "joint2", coupling.leaders.front().first);
    set_attribute(node, "polycoef",
                  fmt::format("{} {} 0 0 0", offset + 0.0, is_belt ? 0.0 : coupling.leaders.front().second + 0.0));
    set_stiffness(node);
  }

  static void set_stiffness(pugi::xml_node equality) {
    set_attribute(equality, "solref", closure_solref);
    set_attribute(equality, "solimp", closure_solimp);
  }

  void add_equalities(pugi::xml_node root) {
    pugi::xml_node equalities = root.append_child("equality");
    for (const RobotCoupling& coupling : tree_.couplings) add_coupling(equalities, coupling);
    UniqueNames names(std::set<std::string>{});
    for (const RobotClosure& closure : tree_.closures) {
      // a closure's first body must not be the world
      const bool is_swapped = closure.first == ground_link;
      const int first = is_swapped ? closure.second : closure.first,
                second = is_swapped ? closure.first : closure.second;
      for (const auto& anchor : {std::optional(closure.anchor), closure.second_anchor}) {
        if (!anchor) continue;
        pugi::xml_node node = equalities.append_child(closure.is_weld ? "weld" : "connect");
        set_attribute(node, "name", names.add(closure.name));
        set_attribute(node, "body1", name_of_link(first));
        if (second != ground_link) set_attribute(node, "body2", name_of_link(second));
        const Pose to_link = pose_of(first).inverse();
        if (!closure.is_weld) set_attribute(node, "anchor", format_xml_numbers(to_link.p + to_link.R * *anchor));
        set_stiffness(node);
      }
    }
    if (!equalities.first_child()) root.remove_child(equalities);
  }

  void add_motors(pugi::xml_node root) {
    if (tree_.motors.empty()) return;
    pugi::xml_node actuator = root.append_child("actuator");
    for (const RobotMotor& motor : tree_.motors) {
      pugi::xml_node node = actuator.append_child("motor");
      set_attribute(node, "name", motor.joint);
      set_attribute(node, "joint", motor.joint);
      if (!motor.lower || !motor.upper) continue;
      set_attribute(node, "ctrllimited", "true");
      set_attribute(node, "ctrlrange", fmt::format("{} {}", *motor.lower, *motor.upper));
    }
  }

  void add_keyframe(pugi::xml_node root) {
    if (!tree_.has_start) return;
    pugi::xml_node key = root.append_child("keyframe").append_child("key");
    std::string values;
    for (const double value : start_) values += (values.empty() ? "" : " ") + format_xml_number(value);
    set_attribute(key, "name", "start");
    set_attribute(key, "qpos", values);
  }

  /// At the head, when everything that is missing is known.
  void add_comments(pugi::xml_node root) {
    std::vector<std::string> lines{
        "SI units. Every joint is a coordinate of the spec or the turn of a disc: qpos are "
        "their values, those of the key 'start' the start pose."};
    if (!tree_.closures.empty())
      lines.emplace_back("Bodies stand at the start pose. MuJoCo closes loops by soft constraints.");
    pugi::xml_document comments;
    add_head_comments(comments.root(), out_, lines);
    pugi::xml_node before = root.first_child();
    for (pugi::xml_node comment : comments.children()) root.insert_copy_before(comment, before);
  }

  const RobotTree& tree_;
  RobotExport& out_;
  std::vector<std::size_t> roots_;
  std::vector<std::vector<std::size_t>> children_;
  UniqueNames body_names_{std::set<std::string>{"world"}}, tendon_names_{std::set<std::string>{}};
  std::vector<std::string> names_, spring_names_;
  std::map<std::string, std::string> belts_;  ///< tendons, by the joint that follows
  std::vector<double> start_;                 ///< of all joints, in the order of the file
};

}  // namespace

void write_mjcf(const RobotTree& tree, RobotExport& out) { MjcfWriter(tree, out).run(); }

}  // namespace balance::foreign
