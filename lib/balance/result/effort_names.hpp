#pragma once
/// How quantities of single actuators are called. One array, "torque", holds the efforts of all; that of a slide is a force, and is
/// called "force[S]" beside the "torque[A1]" of what turns. Its older name, "torque[S]", is understood wherever a name is given.

#include <algorithm>
#include <string>
#include <vector>

namespace balance {

/// "force" for "torque", "force_variation" for "torque_variation", "S.force" for "S.torque", where the unit is a force's.
/// @param name of an array, or its short name
inline std::string effort_name(const std::string& name, const std::string& unit) {
  return name.starts_with("torque") && unit == "N" ? "force" + name.substr(6) : name;
}

/// The array that holds a quantity: "torque" of "torque[A1]" and of "force[S]".
inline std::string array_name(const std::string& quantity) {
  const std::string stem = quantity.substr(0, quantity.find('['));
  const bool force = stem == "force" || stem.starts_with("force_");
  return force ? "torque" + stem.substr(5) : stem;
}

/// "force[S]" for "torque[S]"; names of no single actuator stay as they are.
inline std::string force_name(const std::string& quantity) {
  return quantity.starts_with("torque") && quantity.find('[') != std::string::npos ? "force" + quantity.substr(6)
                                                                                   : quantity;
}

/// What a given name stands for among these: itself, or a slide's force by its older name; itself too if it stands for nothing.
inline std::string known_quantity(const std::string& given, const std::vector<std::string>& names) {
  const auto is_known = [&](const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  return !is_known(given) && is_known(force_name(given)) ? force_name(given) : given;
}

/// Whether a given name is a quantity's own, or a slide's older one.
inline bool is_name_of(const std::string& given, const std::string& quantity) {
  return given == quantity || force_name(given) == quantity;
}

/// The same, or the name of the array that holds it.
inline bool names_quantity(const std::string& given, const std::string& quantity) {
  return is_name_of(given, quantity) || given == array_name(quantity);
}

}  // namespace balance
