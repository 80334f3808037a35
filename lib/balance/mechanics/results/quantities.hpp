#pragma once
/// The sampled quantities of a RunResult: one table for all runs that record them and all formats that present them. A
/// new quantity needs a line of the table in quantities.cpp, a member of Sample and of RunResult, and the code that
/// computes it.

#include "balance/mechanics/results/result.hpp"
#include "balance/mechanics/trajectory/motion_sample.hpp"

#include <algorithm>
#include <span>
#include <string>
#include <vector>

namespace balance::results {

// Names of quantities of single actuators. The array "torque" holds the efforts of all actuators. The effort of a
// sliding actuator is a force and is named "force[S]", next to "torque[A1]" of a rotary one. Its older name "torque[S]"
// is accepted wherever a name is given.

/// "force" for "torque", "force_variation" for "torque_variation", "S.force" for "S.torque" if the unit is that of a
/// force.
/// @param name of an array, or its short name
inline std::string effort_display_name(const std::string& name, const std::string& unit) {
  return name.starts_with("torque") && unit == "N" ? "force" + name.substr(6) : name;
}

/// The array that holds a quantity: "torque" of "torque[A1]" and of "force[S]".
inline std::string effort_array_name(const std::string& quantity) {
  const std::string stem = quantity.substr(0, quantity.find('['));
  const bool force = stem == "force" || stem.starts_with("force_");
  return force ? "torque" + stem.substr(5) : stem;
}

/// "force[S]" for "torque[S]". Names that are not of a single actuator do not change.
inline std::string to_force_name(const std::string& quantity) {
  return quantity.starts_with("torque") && quantity.find('[') != std::string::npos ? "force" + quantity.substr(6)
                                                                                   : quantity;
}

/// The name among `names` that a given name means: itself, or the force of a slide given by its older name. Unknown
/// names do not change.
inline std::string resolve_quantity_name(const std::string& given_name, const std::vector<std::string>& names) {
  const auto is_known = [&](const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  return !is_known(given_name) && is_known(to_force_name(given_name)) ? to_force_name(given_name) : given_name;
}

/// Whether a given name is the name of the quantity, or the older name of a slide's force.
inline bool is_quantity_name(const std::string& given_name, const std::string& quantity) {
  return given_name == quantity || to_force_name(given_name) == quantity;
}

/// The same, or the name of the array that holds the quantity.
inline bool is_quantity_or_array_name(const std::string& given_name, const std::string& quantity) {
  return is_quantity_name(given_name, quantity) || given_name == effort_array_name(quantity);
}

/// What each column of a quantity belongs to.
enum class ColumnKind {
  single,
  coordinate,
  actuator,
  axis,
  quaternion,
  joint,
  joint_axis,
  constraint,
  sliding,
  body,
  body_axis,
  body_quaternion
};

/// Which runs have a quantity.
enum class Availability {
  always,
  tool,               ///< the mechanism has a tool
  uniform_actuators,  ///< there are several actuators, with efforts of the same unit
  reactions,          ///< the formulation computes joint reactions and the mobility
  prescribed_speeds,  ///< as `reactions`, and a constraint on speeds has a value other than zero
  control,            ///< under control
  tracking,           ///< under control, and the desired motion is known
  tool_tracking,      ///< as `tracking`, and the mechanism has a tool
  poses,              ///< on request, computed after the run (mechanics/results/body_poses.hpp)
  split,              ///< on request (mechanics/dynamics/effort_breakdown.hpp)
  measured,           ///< along a record of the machine (motion/simulation/prediction.hpp)
};

/// A line of the table.
struct QuantityDefinition {
  /// In the plane, moments and orientations have one component. In space, moments have three, orientations are
  /// quaternions.
  enum class Shape { plain, moment, orientation };
  /// What the columns take their units from if they do not share one.
  enum class UnitSource { fixed, coordinate, actuator, constraint, sliding, turn };

  /// Which figures are computed.
  enum class MetricScope {
    none,
    whole,                 ///< of the whole scalar or vector
    per_member,            ///< of each joint
    per_member_and_worst,  ///< of each actuator or sliding variable, and of the worst of them
    tracked,               ///< of each actuated coordinate (without actuators: all), and of the worst of them
  };

  const char* name;
  const char* short_name;  ///< suffix to the name of a coordinate, actuator, joint or body
  const char* long_name;
  ColumnKind columns;
  Shape shape;
  UnitSource unit_of;
  const char* unit;  ///< or the suffix to the columns' own units: "/s"
  Availability occasion;
  MetricScope figures;
  Samples RunResult::*member;
  const double* (*values)(const Sample&);  ///< null: not read from single samples
  VectorX TermMagnitudes::*terms;          ///< null: has no round-off
  bool has_moment_reference = false;       ///< a moment about RunResult::moment_reference
};

std::span<const QuantityDefinition> quantity_table();

/// A quantity of one RunResult, which must outlive it.
struct Quantity {
  std::string name;        ///< of the data set: "joint_position"
  std::string short_name;  ///< suffix to the name of a coordinate, actuator or joint: "position"
  std::string long_name;
  std::vector<std::string> units;  ///< one per owner; a single one if all are equal
  ColumnKind columns = ColumnKind::single;
  bool has_moment_reference = false;  ///< a moment about RunResult::moment_reference
  Samples RunResult::*member = nullptr;
  const Samples* samples = nullptr;  ///< that member of the result

  /// @param owner index of a coordinate, actuator, joint, … that columns belong to @param owners number of owners
  const std::string& unit_of(std::size_t owner, std::size_t owners) const {
    return units[units.size() == owners ? owner : 0];
  }
};

/// All quantities of mechanisms of the result's space, with or without samples.
std::vector<Quantity> list_all_quantities(const RunResult& result);

/// Only quantities that have samples.
std::vector<Quantity> list_sampled_quantities(const RunResult& result);

/// The kind of columns in the result's space.
ColumnKind columns_of(const QuantityDefinition& kind, const RunResult& result);

/// Number of columns, from the result's names.
Eigen::Index count_columns(ColumnKind columns, const RunResult& result);

/// "rad" if all are equal, "mixed" if not, "1" if there are none.
std::string common_unit(const std::vector<std::string>& units);

/// The first of "x", "y", "z".
std::vector<std::string> axis_labels(int axes);

std::vector<std::string> quaternion_labels();

}  // namespace balance::results

namespace balance {

using results::Quantity;

}  // namespace balance
