#pragma once
/// What the writers of MJCF, SDF and URDF share.

#include "balance/interface/import/robot_export.hpp"
#include "balance/interface/import/robot_tree.hpp"

#include <pugixml.hpp>

#include <array>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace balance::foreign {

/// Shortest numbers that read back the same, separated by blanks; no negative zero.
std::string format_xml_numbers(const Vector3& v);
std::string format_xml_number(double value);

/// Names of one kind that the format requires to be different.
class UniqueNames {
 public:
  explicit UniqueNames(std::set<std::string> reserved) : used_(std::move(reserved)) {}
  /// The name itself, or with a number that makes it unique.
  std::string add(const std::string& name);

 private:
  std::set<std::string> used_;
};

/// Mass and principal inertia of a link as simulators accept them.
struct XmlInertia {
  double mass = 0;
  Vector3 com = Vector3::Zero();
  Matrix3 axes = Matrix3::Identity();  ///< principal axes, a rotation, link axes
  Vector3 moments = Vector3::Zero();   ///< about these
  bool is_raised = false;              ///< a mass or a moment was zero, and is negligible instead

  Matrix3 tensor() const { return axes * moments.asDiagonal() * axes.transpose(); }
  /// Names and values of the tensor's upper half, as SDF and URDF have them.
  std::array<std::pair<const char*, double>, 6> entries() const;
};

/// Masses [kg] and moments [kg m^2] that are zero become this, because simulators refuse bodies without: far below
/// round-off of the motion.
inline constexpr double negligible_mass = 2e-15;

XmlInertia make_xml_inertia(const RobotLink& link);

/// Adds an attribute to an element.
void set_attribute(pugi::xml_node node, const char* attribute, const std::string& value);
void set_attribute(pugi::xml_node node, const char* attribute, double value);

/// Adds the comments at the head of a file: what it is, and the lists of the export.
void add_head_comments(pugi::xml_node parent, const RobotExport& exported, const std::vector<std::string>& lines);

/// The document as text, indented by two blanks.
std::string format_xml(const pugi::xml_document& document);

/// Names of joints and their values at the start pose, for a comment: "J1 = 0.2, J2 = −1".
std::string format_start_pose(const RobotTree& tree);

// The formats. They add to the notes and to what is missing.
void write_mjcf(const RobotTree& tree, RobotExport& out);
void write_sdf(const RobotTree& tree, RobotExport& out);
void write_urdf(const RobotTree& tree, RobotExport& out);

}  // namespace balance::foreign
