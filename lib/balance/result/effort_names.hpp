#pragma once
/// How quantities of single actuators are called. One array, "torque", holds the efforts of all; that of a slide is a force, and is
/// called "force[S]" beside the "torque[A1]" of what turns. Its older name, "torque[S]", is understood wherever a name is given.

#include <algorithm>
#include <string>
#include <vector>

namespace balance {

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

}  // namespace balance
