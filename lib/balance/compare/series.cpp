#include "balance/compare/series.hpp"

#include "balance/result/round_off.hpp"

#include <string_view>
#include <unordered_map>

namespace balance {

std::vector<QuantitySeries> list_series(const Result& result) {
  std::vector<QuantitySeries> all;
  const auto add = [&](const std::string& quantity, Samples Result::*array, int first, int count) {
    const Samples& samples = result.*array;
    const bool there = samples.rows() == result.time.size() && samples.cols() >= first + count;
    if (there && samples.rows() > 0)
      all.push_back({quantity, &samples, first, count, round_off_of(result, array, first)});
  };
  const auto add_each = [&](const std::string& quantity, const std::vector<std::string>& names,
                            Samples Result::*samples, int count) {
    for (std::size_t i = 0; i < names.size(); ++i)
      add(quantity + "[" + names[i] + "]", samples, static_cast<int>(i) * count, count);
  };
  std::unordered_map<std::string_view, int> column_of;
  int columns = 0;
  for (const std::string& name : result.coordinate_names) column_of.emplace(name, columns++);
  for (const std::string& name : result.actuator_names)
    if (const auto at = column_of.find(name); at != column_of.end())
      add("tracking_error[" + name + "]", &Result::tracking_error, at->second, 1);
  add("tool_error", &Result::tool_error, 0, result.axes);
  add("tool_angle_error", &Result::tool_angle_error, 0, 1);
  add_each("sliding_variable", result.sliding_names, &Result::sliding_variable, 1);
  add_each("torque_variation", result.actuator_names, &Result::torque_variation, 1);
  add_each("saturation", result.actuator_names, &Result::saturation, 1);
  add_each("torque", result.actuator_names, &Result::torque, 1);
  add_each("power", result.actuator_names, &Result::power, 1);
  add("shaking_force", &Result::shaking_force, 0, result.axes);
  add("shaking_moment", &Result::shaking_moment, 0, result.moment_axes);
  add("ground_force", &Result::ground_force, 0, result.axes);
  add("ground_moment", &Result::ground_moment, 0, result.moment_axes);
  add("com_velocity", &Result::com_velocity, 0, result.axes);
  add("com_acceleration", &Result::com_acceleration, 0, result.axes);
  add("kinetic_energy", &Result::kinetic_energy, 0, 1);
  add_each("joint_force", result.joint_names, &Result::joint_force, result.axes);
  add_each("joint_moment", result.joint_names, &Result::joint_moment, result.moment_axes);
  return all;
}

}  // namespace balance
