#include "balance/interface/import/robot_export.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/import/robot_xml.hpp"

#include <fmt/format.h>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace balance::foreign {

RobotFormat choose_robot_format(const std::string& name, const std::string& file) {
  using Choice = std::pair<const char*, RobotFormat>;
  static constexpr std::array names{Choice{"mjcf", RobotFormat::mjcf}, Choice{"sdf", RobotFormat::sdf},
                                    Choice{"urdf", RobotFormat::urdf}};
  static constexpr std::array suffixes{Choice{".xml", RobotFormat::mjcf}, Choice{".mjcf", RobotFormat::mjcf},
                                       Choice{".sdf", RobotFormat::sdf}, Choice{".world", RobotFormat::sdf},
                                       Choice{".urdf", RobotFormat::urdf}};
  for (const auto& [word, format] : names)
    if (name == word) return format;
  if (name.empty())
    for (const auto& [suffix, format] : suffixes)
      if (file.ends_with(suffix)) return format;
  throw std::invalid_argument(
      "expected mjcf, sdf or urdf, or a file that ends in .xml or .mjcf (MJCF), .sdf or .world (SDF), .urdf; found " +
      quote_for_message(name.empty() ? file : name));
}

const char* name_of(RobotFormat format) {
  switch (format) {
    case RobotFormat::mjcf: return "MJCF";
    case RobotFormat::sdf: return "SDF";
    case RobotFormat::urdf: return "URDF";
  }
  return "";
}

std::string format_xml_number(double value) { return fmt::format("{}", value + 0.0); }

std::string format_xml_numbers(const Vector3& v) {
  return fmt::format("{} {} {}", v.x() + 0.0, v.y() + 0.0, v.z() + 0.0);
}

std::string UniqueNames::add(const std::string& name) {
  std::string candidate = name;
  for (int k = 2; !used_.insert(candidate).second; ++k) candidate = fmt::format("{} {}", name, k);
  return candidate;
}

namespace {

/// Moments that violate the triangle inequality by less are those of a rod or a plate with round-off.
constexpr double triangle_round_off = 1e-9;

}  // namespace

XmlInertia make_xml_inertia(const RobotLink& link) {
  XmlInertia out;
  out.mass = link.mass;
  out.com = link.com;
  if (Matrix3 off = link.inertia; (off.diagonal().setZero(), off.isZero(0))) {
    out.moments = link.inertia.diagonal();
  } else {
    const Eigen::SelfAdjointEigenSolver<Matrix3> principal(0.5 * (link.inertia + link.inertia.transpose()));
    out.moments = principal.eigenvalues();
    out.axes = principal.eigenvectors();
    if (out.axes.determinant() < 0) out.axes.col(2) *= -1;
  }
  for (int k = 0; k < 3; ++k) {
    const double deficit = out.moments[k] - out.moments[(k + 1) % 3] - out.moments[(k + 2) % 3];
    if (deficit > 0 && deficit <= triangle_round_off * out.moments[k]) {
      out.moments[(k + 1) % 3] += deficit;
      out.moments[(k + 2) % 3] += deficit;
    }
  }
  out.is_raised = !(out.mass >= negligible_mass) ||
                  !(std::min({out.moments[0], out.moments[1], out.moments[2]}) >= negligible_mass);
  out.mass = std::max(out.mass, negligible_mass);
  out.moments = out.moments.cwiseMax(negligible_mass);
  return out;
}

std::string format_start_pose(const RobotTree& tree) {
  std::string text;
  for (const RobotLink& link : tree.links)
    for (const RobotJoint& joint : link.joints)
      text += fmt::format("{}{} = {:.9g}", text.empty() ? "" : ", ", joint.name, joint.start + 0.0);
  return text;
}

std::array<std::pair<const char*, double>, 6> XmlInertia::entries() const {
  const Matrix3 I = tensor();
  return {{{"ixx", I(0, 0)}, {"ixy", I(0, 1)}, {"ixz", I(0, 2)}, {"iyy", I(1, 1)}, {"iyz", I(1, 2)}, {"izz", I(2, 2)}}};
}

void set_attribute(pugi::xml_node node, const char* attribute, const std::string& value) {
  node.append_attribute(attribute) = value.c_str();
}

void set_attribute(pugi::xml_node node, const char* attribute, double value) {
  set_attribute(node, attribute, format_xml_number(value));
}

void add_head_comments(pugi::xml_node parent, const RobotExport& exported, const std::vector<std::string>& lines) {
  const auto add = [&](const std::string& text) {
    parent.append_child(pugi::node_comment).set_value((" " + text + " ").c_str());
  };
  for (const std::string& line : lines) add(line);
  for (const std::string& note : exported.notes) add("Note: " + note);
  for (const std::string& what : exported.missing) add("Not in this file: " + what);
}

std::string format_xml(const pugi::xml_document& document) {
  std::ostringstream stream;
  document.save(stream, "  ", pugi::format_default | pugi::format_no_declaration, pugi::encoding_utf8);
  return std::move(stream).str();
}

RobotExport export_robot(const Study& study, RobotFormat format, const std::string& trajectory) {
  const bool is_mjcf = format == RobotFormat::mjcf;
  const RobotTree tree = make_robot_tree(study, trajectory, is_mjcf ? ReferencePose::closed : ReferencePose::zero);
  RobotExport out;
  out.missing = tree.missing;
  std::string raised;
  for (const RobotLink& link : tree.links)
    if (make_xml_inertia(link).is_raised && (!link.joints.empty() || link.mass > 0))
      raised += (raised.empty() ? "" : ", ") + quote_for_message(link.name);
  if (!raised.empty())
    out.notes.push_back(
        fmt::format("no mass or inertia about some axis: {:g} kg or kg m^2 instead, which simulators "
                    "need: {}",
                    negligible_mass, raised));
  switch (format) {
    case RobotFormat::mjcf: write_mjcf(tree, out); break;
    case RobotFormat::sdf: write_sdf(tree, out); break;
    case RobotFormat::urdf: write_urdf(tree, out); break;
  }
  return out;
}

}  // namespace balance::foreign
