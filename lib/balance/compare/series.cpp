#include "balance/compare/series.hpp"

#include <string_view>
#include <unordered_map>

namespace balance {

std::vector<QuantitySeries> list_series(const Result& result) {
  std::vector<QuantitySeries> all;
  const auto add = [&](const std::string& quantity, const Samples& samples, int first, int count) {
    const bool there = samples.rows() == result.time.size() && samples.cols() >= first + count;
    if (there && samples.rows() > 0) all.push_back({quantity, &samples, first, count});
  };
  const auto add_each = [&](const std::string& quantity, const std::vector<std::string>& names, const Samples& samples,
                            int count) {
    for (std::size_t i = 0; i < names.size(); ++i)
      add(quantity + "[" + names[i] + "]", samples, static_cast<int>(i) * count, count);
  };
  std::unordered_map<std::string_view, int> column_of;
  int columns = 0;
  for (const std::string& name : result.coordinate_names) column_of.emplace(name, columns++);
  for (const std::string& name : result.actuator_names)
    if (const auto at = column_of.find(name); at != column_of.end())
      add("tracking_error[" + name + "]", result.tracking_error, at->second, 1);
  add("tool_error", result.tool_error, 0, result.axes);
  add("tool_angle_error", result.tool_angle_error, 0, 1);
  add_each("sliding_variable", result.sliding_names, result.sliding_variable, 1);
  add_each("torque_variation", result.actuator_names, result.torque_variation, 1);
  add_each("saturation", result.actuator_names, result.saturation, 1);
  add_each("torque", result.actuator_names, result.torque, 1);
  add_each("power", result.actuator_names, result.power, 1);
  add("shaking_force", result.shaking_force, 0, result.axes);
  add("shaking_moment", result.shaking_moment, 0, result.moment_axes);
  add("ground_force", result.ground_force, 0, result.axes);
  add("ground_moment", result.ground_moment, 0, result.moment_axes);
  add("com_velocity", result.com_velocity, 0, result.axes);
  add("com_acceleration", result.com_acceleration, 0, result.axes);
  add("kinetic_energy", result.kinetic_energy, 0, 1);
  add_each("joint_force", result.joint_names, result.joint_force, result.axes);
  add_each("joint_moment", result.joint_names, result.joint_moment, result.moment_axes);
  return all;
}

}  // namespace balance
