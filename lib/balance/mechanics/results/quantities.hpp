#pragma once
/// The sampled quantities of a RunResult: one table for every run that records them and every format that shows them. A new quantity is
/// a line of the table in quantities.cpp, a member of Sample and of RunResult, and the place that computes it.

#include "balance/mechanics/results/result.hpp"
#include "balance/mechanics/trajectory/motion_sample.hpp"

#include <algorithm>
#include <span>
#include <string>
#include <vector>

namespace balance {

// How quantities of single actuators are called. One array, "torque", holds the efforts of all; that of a slide is a force, and is
// called "force[S]" beside the "torque[A1]" of what turns. Its older name, "torque[S]", is understood wherever a name is given.

/// "force" for "torque", "force_variation" for "torque_variation", "S.force" for "S.torque", where the unit is a force's.
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

/// "force[S]" for "torque[S]"; names of no single actuator stay as they are.
inline std::string to_force_name(const std::string& quantity) {
  return quantity.starts_with("torque") && quantity.find('[') != std::string::npos ? "force" + quantity.substr(6)
                                                                                   : quantity;
}

/// What a given name stands for among these: itself, or a slide's force by its older name; itself too if it stands for nothing.
inline std::string resolve_quantity_name(const std::string& given, const std::vector<std::string>& names) {
  const auto is_known = [&](const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  return !is_known(given) && is_known(to_force_name(given)) ? to_force_name(given) : given;
}

/// Whether a given name is a quantity's own, or a slide's older one.
inline bool is_quantity_name(const std::string& given, const std::string& quantity) {
  return given == quantity || to_force_name(given) == quantity;
}

/// The same, or the name of the array that holds it.
inline bool is_quantity_or_array_name(const std::string& given, const std::string& quantity) {
  return is_quantity_name(given, quantity) || given == effort_array_name(quantity);
}

/// What the columns of a quantity belong to.
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
  uniform_actuators,  ///< several actuators, and their efforts have one unit
  reactions,          ///< the formulation knows what single joints transmit, and how near a singularity is
  control,            ///< under control
  tracking,           ///< and the desired motion is known
  tool_tracking,      ///< and there is a tool
  poses,              ///< asked for, and computed after the run (mechanics/results/body_poses.hpp)
  split,              ///< the same (mechanics/dynamics/effort_breakdown.hpp)
};

/// A line of the table.
struct QuantityDefinition {
  /// In the plane moments and turns have one component, in space three, or a quaternion.
  enum class Shape { plain, moment, orientation };
  /// Whose unit the columns have, where it is not the same for all of them.
  enum class UnitSource { fixed, coordinate, actuator, constraint, sliding, turn };

  /// Which figures there are of it.
  enum class MetricScope {
    none,
    whole,                 ///< of the scalar or vector
    per_member,            ///< of each joint's
    per_member_and_worst,  ///< of each actuator's or variable's, and the worst of them
    tracked,               ///< of each coordinate's that is to be led, and the worst of them
  };

  const char* name;
  const char* short_name;  ///< behind the name of a coordinate, actuator, joint or body
  const char* long_name;
  ColumnKind columns;
  Shape shape;
  UnitSource unit_of;
  const char* unit;  ///< or what follows the columns' own: "/s"
  Availability occasion;
  MetricScope figures;
  Samples RunResult::*member;
  const double* (*values)(const Sample&);  ///< null: not read off samples one by one
  VectorX TermMagnitudes::*terms;          ///< null: never round-off
  bool has_moment_reference = false;       ///< a moment about RunResult::moment_reference
};

std::span<const QuantityDefinition> quantity_table();

/// A quantity of one RunResult, which must outlive it.
struct Quantity {
  std::string name;        ///< of the dataset: "joint_position"
  std::string short_name;  ///< behind the name of a coordinate, actuator or joint: "position"
  std::string long_name;
  std::vector<std::string> units;  ///< one per column; one for all if they are alike
  ColumnKind columns = ColumnKind::single;
  bool has_moment_reference = false;  ///< a moment about RunResult::moment_reference
  Samples RunResult::*member = nullptr;
  const Samples* samples = nullptr;  ///< that member of the result

  /// @param owner index of a coordinate, actuator, joint, … that columns belong to @param owners how many there are
  const std::string& unit_of(std::size_t owner, std::size_t owners) const {
    return units[units.size() == owners ? owner : 0];
  }
};

/// All that there are for mechanisms of the result's space, with or without samples.
std::vector<Quantity> list_all_quantities(const RunResult& result);

/// Quantities without columns (no tool, no actuator) are left out.
std::vector<Quantity> list_sampled_quantities(const RunResult& result);

/// What a kind's columns are in the result's space.
ColumnKind columns_of(const QuantityDefinition& kind, const RunResult& result);

/// How many there are, by the result's names.
Eigen::Index count_columns(ColumnKind columns, const RunResult& result);

/// "rad" if all are alike, else "mixed"; "1" for none.
std::string common_unit(const std::vector<std::string>& units);

/// The first of "x", "y", "z".
std::vector<std::string> axis_labels(int axes);

std::vector<std::string> quaternion_labels();

}  // namespace balance
