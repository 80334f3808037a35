#include "balance/result/quantities.hpp"

#include <algorithm>

namespace balance {
namespace {

std::vector<std::string> per(const std::vector<std::string>& units, const char* divisor) {
  std::vector<std::string> result;
  for (const std::string& unit : units) result.push_back(unit + divisor);
  return result;
}

/// What only runs under control have.
void add_control(const Result& r, std::vector<Quantity>& all) {
  using enum Columns;
  const auto add = [&](const char* name, const char* short_name, const char* long_name, std::vector<std::string> units,
                       Columns columns, Samples Result::*member) {
    all.push_back({name, short_name, long_name, std::move(units), columns, false, member});
  };
  add("desired_position", "desired", "joint coordinate of the desired motion", r.coordinate_units, coordinate,
      &Result::desired_position);
  add("tracking_error", "error", "tracking error of the joint coordinate, desired minus actual", r.coordinate_units,
      coordinate, &Result::tracking_error);
  add("desired_tool_position", "", "tool of the desired motion", {"m"}, axis, &Result::desired_tool_position);
  add("tool_error", "", "tracking error of the tool, desired minus actual", {"m"}, axis, &Result::tool_error);
  add("tool_angle_error", "", "angle between the desired and the actual orientation of the tool", {"rad"}, single,
      &Result::tool_angle_error);
  add("sliding_variable", "sliding", "sliding variable, minus the rate of the error minus lambda times the error",
      r.sliding_units, sliding, &Result::sliding_variable);
  add("torque_variation", "torque_variation", "sum of all changes of the torque so far, without sign", r.actuator_units,
      actuator, &Result::torque_variation);
  add("saturation", "saturation", "1 while the torque is cut by its limit, else 0", {"1"}, actuator,
      &Result::saturation);
}

}  // namespace

std::vector<std::string> axis_labels(int axes) {
  const std::vector<std::string> all = {"x", "y", "z"};
  return {all.begin(), all.begin() + axes};
}

std::vector<std::string> quaternion_labels() { return {"w", "x", "y", "z"}; }

std::string common_unit(const std::vector<std::string>& units) {
  if (units.empty()) return "1";
  const bool alike = std::all_of(units.begin(), units.end(), [&](const auto& unit) { return unit == units.front(); });
  return alike ? units.front() : "mixed";
}

std::vector<Quantity> all_quantities(const Result& r) {
  using enum Columns;
  const bool planar = r.moment_axes == 1;
  const Columns moment = planar ? single : axis;
  const std::string sense = planar ? ", counter-clockwise" : "";
  std::vector<Quantity> all = {
      {"joint_position", "position", "joint coordinate", r.coordinate_units, coordinate, false,
       &Result::joint_position},
      {"joint_velocity", "velocity", "rate of the joint coordinate", per(r.coordinate_units, "/s"), coordinate, false,
       &Result::joint_velocity},
      {"joint_acceleration", "acceleration", "second rate of the joint coordinate", per(r.coordinate_units, "/s^2"),
       coordinate, false, &Result::joint_acceleration},
      {"torque", "torque", "torque or force of the actuator", r.actuator_units, actuator, false, &Result::torque},
      {"power", "power", "power of the actuator", {"W"}, actuator, false, &Result::power},
      {"com_position", "", "centre of mass of all moving bodies", {"m"}, axis, false, &Result::com_position},
      {"com_velocity", "", "velocity of the centre of mass", {"m/s"}, axis, false, &Result::com_velocity},
      {"com_acceleration", "", "acceleration of the centre of mass", {"m/s^2"}, axis, false, &Result::com_acceleration},
      {"tool_position", "", "position of the tool", {"m"}, axis, false, &Result::tool_position},
      {"tool_orientation",
       "",
       planar ? "angle of the tool" : "orientation of the tool as unit quaternion",
       {planar ? "rad" : "1"},
       planar ? single : quaternion,
       false,
       &Result::tool_orientation},
      {"shaking_force",
       "",
       "shaking force: rate of the total linear momentum",
       {"N"},
       axis,
       false,
       &Result::shaking_force},
      {"shaking_moment",
       "",
       "shaking moment: rate of the total angular momentum" + sense,
       {"N m"},
       moment,
       true,
       &Result::shaking_moment},
      {"ground_force", "", "force on the frame, weight included", {"N"}, axis, false, &Result::ground_force},
      {"ground_moment",
       "",
       "moment on the frame, weight included" + sense,
       {"N m"},
       moment,
       true,
       &Result::ground_moment},
      {"joint_force",
       "force",
       "reaction force of the joint on its second body",
       {"N"},
       joint_axis,
       false,
       &Result::joint_force},
      {"joint_moment",
       "moment",
       "reaction moment of the joint on its second body, about the joint's point on it" + sense,
       {"N m"},
       planar ? joint : joint_axis,
       false,
       &Result::joint_moment},
      {"kinetic_energy", "", "kinetic energy", {"J"}, single, false, &Result::kinetic_energy},
      {"potential_energy",
       "",
       "potential energy of weight and springs",
       {"J"},
       single,
       false,
       &Result::potential_energy},
      {"mobility",
       "",
       "smallest singular value of the scaled drive Jacobian; zero at a singularity",
       {"1"},
       single,
       false,
       &Result::mobility},
  };
  add_control(r, all);
  for (Quantity& quantity : all) quantity.samples = &(r.*quantity.member);
  return all;
}

std::vector<Quantity> list_quantities(const Result& r) {
  std::vector<Quantity> all = all_quantities(r);
  std::erase_if(all, [](const Quantity& quantity) { return quantity.samples->size() == 0; });
  return all;
}

}  // namespace balance
