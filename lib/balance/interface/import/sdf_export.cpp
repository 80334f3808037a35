// SDF: a world with the tree at zero coordinates.

#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/import/axis_chain.hpp"
#include "balance/interface/import/robot_xml.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace balance::foreign {

namespace {

/// The first version whose joints may follow another (`mimic`).
constexpr const char* sdf_version = "1.11";

class SdfWriter {
 public:
  SdfWriter(const RobotTree& tree, RobotExport& out) : tree_(tree), out_(out), links_(list_axis_links(tree)) {
    for (AxisLink& link : links_) link.name = names_.add(allowed_name(link.name));
    for (AxisLink& link : links_) {
      const std::string unique = names_.add(allowed_name(link.joint_name));
      if (link.joint != nullptr && unique != link.joint_name) renamed_[link.joint_name] = unique;
      link.joint_name = unique;
    }
  }

  void run() {
    pugi::xml_document document;
    pugi::xml_node root = document.append_child("sdf");
    set_attribute(root, "version", sdf_version);
    find_missing();
    std::vector<std::string> lines{"SI units. Every movable joint is a coordinate of the spec or the turn of a disc."};
    if (tree_.has_start) lines.push_back("Start pose: " + format_start_pose(tree_));
    for (const std::string& closure : describe_closures(tree_)) lines.push_back(closure);
    for (const auto& [name, unique] : renamed_)
      out_.notes.push_back(fmt::format("the joint {} is called {}, because names of links and joints must differ",
                                       quote_for_message(name), quote_for_message(unique)));
    add_head_comments(root, out_, lines);
    pugi::xml_node world = root.append_child("world");
    set_attribute(world, "name", "default");
    set_text(world, "gravity", format_xml_numbers(tree_.gravity));
    pugi::xml_node model = world.append_child("model");
    set_attribute(model, "name", allowed_name(tree_.name));
    for (const AxisLink& link : links_) add_link(model, link);
    for (const AxisLink& link : links_) add_joint(model, link);
    out_.text = format_xml(document);
  }

 private:
  static void set_text(pugi::xml_node parent, const char* element, const std::string& text) {
    parent.append_child(element).text() = text.c_str();
  }
  static void set_text(pugi::xml_node parent, const char* element, double value) {
    set_text(parent, element, format_xml_number(value));
  }

  /// SDF reserves "::" and names within "__".
  static std::string allowed_name(std::string name) {
    for (std::size_t at = name.find("::"); at != std::string::npos; at = name.find("::")) name.erase(at, 1);
    return name.size() >= 4 && name.starts_with("__") && name.ends_with("__") ? name + " 2" : name;
  }

  void find_missing() {
    for (const std::string& closure : describe_closures(tree_)) out_.missing.push_back(closure);
    report_point_springs(tree_, out_.missing);
    report_split_couplings(tree_, out_.missing);
    for (const AxisLink& link : links_)
      if (link.joint != nullptr && link.joint->stiffness == 0 && link.joint->preload != 0)
        out_.missing.push_back(fmt::format("the constant effort on {}, of a spring without stiffness",
                                           quote_for_message(link.joint->name)));
    if (std::any_of(links_.begin(), links_.end(), [](const AxisLink& link) { return link.link == nullptr; }))
      out_.notes.push_back(
          fmt::format("joints with several coordinates are chains of joints with links of {:g} kg, "
                      "named '… before …'",
                      negligible_mass));
  }

  std::string parent_name(const AxisLink& one) const {
    return one.parent == ground_link ? "world" : links_[static_cast<std::size_t>(one.parent)].name;
  }

  void add_link(pugi::xml_node model, const AxisLink& one) {
    pugi::xml_node node = model.append_child("link");
    set_attribute(node, "name", one.name);
    const bool is_on_ground = one.parent == ground_link;
    const Pose relative = relative_pose(links_, one);
    set_text(node, "pose", format_xml_numbers(relative.p) + " " + format_xml_numbers(rpy_of(relative.R)));
    if (!is_on_ground) set_attribute(node.child("pose"), "relative_to", parent_name(one));
    RobotLink between;
    const XmlInertia inertia = make_xml_inertia(one.link != nullptr ? *one.link : between);
    pugi::xml_node inertial = node.append_child("inertial");
    const Vector3 com = one.link != nullptr ? one.place(inertia.com) : Vector3(Vector3::Zero());
    set_text(inertial, "pose", format_xml_numbers(com) + " 0 0 0");
    set_text(inertial, "mass", inertia.mass);
    pugi::xml_node tensor = inertial.append_child("inertia");
    for (const auto& [key, value] : inertia.entries()) set_text(tensor, key, value);
  }

  std::string joint_name(const std::string& coordinate) const {
    const auto renamed = renamed_.find(coordinate);
    return renamed == renamed_.end() ? coordinate : renamed->second;
  }

  void add_joint(pugi::xml_node model, const AxisLink& one) {
    pugi::xml_node node = model.append_child("joint");
    set_attribute(node, "name", one.joint_name);
    set_attribute(node, "type", one.joint == nullptr ? "fixed" : one.joint->is_rotation ? "revolute" : "prismatic");
    set_text(node, "parent", parent_name(one));
    set_text(node, "child", one.name);
    if (one.joint == nullptr) return;
    pugi::xml_node axis = node.append_child("axis");
    set_text(axis, "xyz", format_xml_numbers(one.pose.R.transpose() * one.joint->axis));
    for (const RobotCoupling& coupling : tree_.couplings) {
      if (coupling.joint != one.joint->name || coupling.leaders.size() != 1) continue;
      pugi::xml_node mimic = axis.append_child("mimic");
      set_attribute(mimic, "joint", joint_name(coupling.leaders.front().first));
      set_attribute(mimic, "axis", "axis");
      set_text(mimic, "multiplier", coupling.leaders.front().second);
      set_text(mimic, "offset", coupling.offset);
      set_text(mimic, "reference", 0);
    }
    const RobotMotor* motor = find_motor(tree_, one.joint->name);
    if (motor != nullptr && motor->lower && motor->upper)
      set_text(axis.append_child("limit"), "effort", std::max(std::abs(*motor->lower), std::abs(*motor->upper)));
    if (one.joint->viscous == 0 && one.joint->coulomb == 0 && one.joint->stiffness == 0) return;
    pugi::xml_node dynamics = axis.append_child("dynamics");
    set_text(dynamics, "damping", one.joint->viscous);
    set_text(dynamics, "friction", one.joint->coulomb);
    if (one.joint->stiffness == 0) return;
    set_text(dynamics, "spring_reference", one.joint->preload / one.joint->stiffness);
    set_text(dynamics, "spring_stiffness", one.joint->stiffness);
  }

  const RobotTree& tree_;
  RobotExport& out_;
  std::vector<AxisLink> links_;
  UniqueNames names_{std::set<std::string>{"world"}};
  std::map<std::string, std::string> renamed_;  ///< joints, by their coordinate
};

}  // namespace

void write_sdf(const RobotTree& tree, RobotExport& out) { SdfWriter(tree, out).run(); }

}  // namespace balance::foreign
