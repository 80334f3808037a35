// URDF: the tree at zero coordinates. It has no gravity, springs or start pose.

#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/import/axis_chain.hpp"
#include "balance/interface/import/robot_xml.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace balance::foreign {

namespace {

/// URDF asks for limits of slides and of efforts; these are none.
constexpr const char* no_limit = "1e9";

class UrdfWriter {
 public:
  UrdfWriter(const RobotTree& tree, RobotExport& out) : tree_(tree), out_(out), links_(list_axis_links(tree)) {}

  void run() {
    pugi::xml_document document;
    pugi::xml_node robot = document.append_child("robot");
    set_attribute(robot, "name", tree_.name);
    find_missing();
    std::vector<std::string> lines{"SI units. Every movable joint is a coordinate of the spec or the turn of a disc."};
    if (tree_.has_start) lines.push_back("Start pose: " + format_start_pose(tree_));
    for (const std::string& closure : describe_closures(tree_)) lines.push_back(closure);
    add_head_comments(robot, out_, lines);
    set_attribute(robot.append_child("link"), "name", "world");
    UniqueNames names(std::set<std::string>{"world"});
    for (AxisLink& link : links_) link.name = names.add(link.name);
    for (const AxisLink& link : links_) add_link(robot, link);
    UniqueNames joint_names(std::set<std::string>{});
    for (AxisLink& link : links_)
      if (link.joint == nullptr) link.joint_name = joint_names.add(link.joint_name);
    for (const AxisLink& link : links_) add_joint(robot, link);
    add_transmissions(robot);
    out_.text = format_xml(document);
  }

 private:
  void find_missing() {
    for (const std::string& closure : describe_closures(tree_)) out_.missing.push_back(closure);
    report_point_springs(tree_, out_.missing);
    for (const AxisLink& link : links_)
      if (link.joint != nullptr && (link.joint->stiffness != 0 || link.joint->preload != 0))
        out_.missing.push_back(fmt::format("the spring in {}", quote_for_message(link.joint->name)));
    report_split_couplings(tree_, out_.missing);
    out_.notes.push_back(
        fmt::format("a URDF has no gravity: set ({}) m/s^2 in the simulator", format_xml_numbers(tree_.gravity)));
    if (std::any_of(links_.begin(), links_.end(), [](const AxisLink& link) { return link.link == nullptr; }))
      out_.notes.emplace_back(
          "joints with several coordinates are chains of joints with links without mass, "
          "named '… before …'");
  }

  void add_link(pugi::xml_node robot, const AxisLink& one) {
    pugi::xml_node node = robot.append_child("link");
    set_attribute(node, "name", one.name);
    if (one.link == nullptr || (one.joint == nullptr && one.link->mass == 0)) return;
    const XmlInertia inertia = make_xml_inertia(*one.link);
    pugi::xml_node inertial = node.append_child("inertial");
    set_attribute(inertial.append_child("origin"), "xyz", format_xml_numbers(one.place(inertia.com)));
    set_attribute(inertial.append_child("mass"), "value", inertia.mass);
    pugi::xml_node tensor = inertial.append_child("inertia");
    for (const auto& [key, value] : inertia.entries()) set_attribute(tensor, key, value);
  }

  void add_joint(pugi::xml_node robot, const AxisLink& one) {
    pugi::xml_node node = robot.append_child("joint");
    set_attribute(node, "name", one.joint_name);
    const bool is_slide = one.joint != nullptr && !one.joint->is_rotation;
    set_attribute(node, "type", one.joint == nullptr ? "fixed" : is_slide ? "prismatic" : "continuous");
    const bool is_on_ground = one.parent == ground_link;
    const Pose relative = relative_pose(links_, one);
    pugi::xml_node origin = node.append_child("origin");
    set_attribute(origin, "xyz", format_xml_numbers(relative.p));
    set_attribute(origin, "rpy", format_xml_numbers(rpy_of(relative.R)));
    set_attribute(node.append_child("parent"), "link",
                  is_on_ground ? "world" : links_[static_cast<std::size_t>(one.parent)].name);
    set_attribute(node.append_child("child"), "link", one.name);
    if (one.joint == nullptr) return;
    set_attribute(node.append_child("axis"), "xyz", format_xml_numbers(one.pose.R.transpose() * one.joint->axis));
    const RobotMotor* motor = find_motor(tree_, one.joint->name);
    const bool is_limited = motor != nullptr && motor->lower && motor->upper;
    if (is_slide || is_limited) {
      pugi::xml_node limit = node.append_child("limit");
      set_attribute(limit, "lower", std::string("-") + no_limit);
      set_attribute(limit, "upper", no_limit);
      set_attribute(limit, "effort",
                    is_limited ? format_xml_number(std::max(std::abs(*motor->lower), std::abs(*motor->upper)))
                               : std::string(no_limit));
      set_attribute(limit, "velocity", no_limit);
    }
    if (one.joint->viscous != 0 || one.joint->coulomb != 0) {
      pugi::xml_node dynamics = node.append_child("dynamics");
      set_attribute(dynamics, "damping", one.joint->viscous);
      set_attribute(dynamics, "friction", one.joint->coulomb);
    }
    for (const RobotCoupling& coupling : tree_.couplings) {
      if (coupling.joint != one.joint->name || coupling.leaders.size() != 1) continue;
      pugi::xml_node mimic = node.append_child("mimic");
      set_attribute(mimic, "joint", coupling.leaders.front().first);
      set_attribute(mimic, "multiplier", coupling.leaders.front().second);
      set_attribute(mimic, "offset", coupling.offset);
    }
  }

  void add_transmissions(pugi::xml_node robot) {
    for (const RobotMotor& motor : tree_.motors) {
      pugi::xml_node node = robot.append_child("transmission");
      set_attribute(node, "name", motor.joint);
      node.append_child("type").text() = "transmission_interface/SimpleTransmission";
      pugi::xml_node joint = node.append_child("joint");
      set_attribute(joint, "name", motor.joint);
      joint.append_child("hardwareInterface").text() = "hardware_interface/EffortJointInterface";
      pugi::xml_node actuator = node.append_child("actuator");
      set_attribute(actuator, "name", motor.joint);
    }
  }

  const RobotTree& tree_;
  RobotExport& out_;
  std::vector<AxisLink> links_;
};

}  // namespace

void write_urdf(const RobotTree& tree, RobotExport& out) { UrdfWriter(tree, out).run(); }

}  // namespace balance::foreign
