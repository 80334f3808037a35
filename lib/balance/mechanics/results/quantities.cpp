#include "balance/mechanics/results/quantities.hpp"

#include <algorithm>
#include <iterator>

namespace balance::results {
namespace {

using enum ColumnKind;
using Shape = QuantityDefinition::Shape;
using Unit = QuantityDefinition::UnitSource;
using Figures = QuantityDefinition::MetricScope;

constexpr const char* about_its_point =
    "reaction moment of the joint on its second body, about the joint's point on it";
constexpr const char* about_moving_com = "rate of the total angular momentum about the moving centre of mass";

// clang-format off
constexpr QuantityDefinition quantity_definitions[] = {
    {"joint_position", "position", "joint coordinate", coordinate, Shape::plain, Unit::coordinate, "", Availability::always, Figures::none,
     &RunResult::joint_position, [](const Sample& s) { return s.position.data(); }, &TermMagnitudes::position},
    {"joint_velocity", "velocity", "rate of the joint coordinate", coordinate, Shape::plain, Unit::coordinate, "/s", Availability::always, Figures::none,
     &RunResult::joint_velocity, [](const Sample& s) { return s.velocity.data(); }, &TermMagnitudes::velocity},
    {"joint_acceleration", "acceleration", "second derivative of the joint coordinate", coordinate, Shape::plain, Unit::coordinate, "/s^2", Availability::always, Figures::none,
     &RunResult::joint_acceleration, [](const Sample& s) { return s.acceleration.data(); }, &TermMagnitudes::acceleration},
    {"torque", "torque", "torque or force of the actuator", actuator, Shape::plain, Unit::actuator, "", Availability::always, Figures::per_member_and_worst,
     &RunResult::torque, [](const Sample& s) { return s.effort.data(); }, &TermMagnitudes::effort},
    {"total_torque", "", "root of the sum of the actuators' squared torques or forces", single, Shape::plain, Unit::actuator, "", Availability::uniform_actuators, Figures::whole,
     &RunResult::total_torque, [](const Sample& s) { return &s.total_torque; }, &TermMagnitudes::total_effort},
    {"power", "power", "power of the actuator", actuator, Shape::plain, Unit::fixed, "W", Availability::always, Figures::per_member_and_worst,
     &RunResult::power, [](const Sample& s) { return s.power.data(); }, &TermMagnitudes::power},
    {"com_position", "", "centre of mass of all moving bodies", axis, Shape::plain, Unit::fixed, "m", Availability::always, Figures::none,
     &RunResult::com_position, [](const Sample& s) { return s.com.data(); }, &TermMagnitudes::com_position},
    {"com_velocity", "", "velocity of the centre of mass", axis, Shape::plain, Unit::fixed, "m/s", Availability::always, Figures::whole,
     &RunResult::com_velocity, [](const Sample& s) { return s.com_velocity.data(); }, &TermMagnitudes::com_velocity},
    {"com_acceleration", "", "acceleration of the centre of mass", axis, Shape::plain, Unit::fixed, "m/s^2", Availability::always, Figures::whole,
     &RunResult::com_acceleration, [](const Sample& s) { return s.com_acceleration.data(); }, &TermMagnitudes::com_acceleration},
    {"tool_position", "", "position of the tool", axis, Shape::plain, Unit::fixed, "m", Availability::tool, Figures::none,
     &RunResult::tool_position, [](const Sample& s) { return s.tool_position.data(); }, &TermMagnitudes::tool_position},
    {"tool_orientation", "", "of the tool", single, Shape::orientation, Unit::turn, "", Availability::tool, Figures::none,
     &RunResult::tool_orientation, [](const Sample& s) { return &s.tool_angle; }, &TermMagnitudes::tool_angle},
    {"shaking_force", "", "shaking force: rate of the total linear momentum", axis, Shape::plain, Unit::fixed, "N", Availability::always, Figures::whole,
     &RunResult::shaking_force, [](const Sample& s) { return s.shaking_force.data(); }, &TermMagnitudes::shaking_force},
    {"shaking_moment", "", "shaking moment: rate of the total angular momentum", axis, Shape::moment, Unit::fixed, "N m", Availability::always, Figures::whole,
     &RunResult::shaking_moment, [](const Sample& s) { return s.shaking_moment.data(); }, &TermMagnitudes::shaking_moment, true},
    {"shaking_moment_com", "", about_moving_com, axis, Shape::moment, Unit::fixed, "N m", Availability::always, Figures::whole,
     &RunResult::shaking_moment_com, [](const Sample& s) { return s.shaking_moment_com.data(); }, &TermMagnitudes::moment_com},
    {"ground_force", "", "force on the frame, weight included", axis, Shape::plain, Unit::fixed, "N", Availability::always, Figures::whole,
     &RunResult::ground_force, [](const Sample& s) { return s.ground_force.data(); }, &TermMagnitudes::force},
    {"ground_moment", "", "moment on the frame, weight included", axis, Shape::moment, Unit::fixed, "N m", Availability::always, Figures::whole,
     &RunResult::ground_moment, [](const Sample& s) { return s.ground_moment.data(); }, &TermMagnitudes::moment, true},
    {"joint_force", "force", "reaction force of the joint on its second body", joint_axis, Shape::plain, Unit::fixed, "N", Availability::reactions, Figures::per_member,
     &RunResult::joint_force, [](const Sample& s) { return s.joint_force.data()->data(); }, &TermMagnitudes::joint_force},
    {"joint_moment", "moment", about_its_point, joint_axis, Shape::moment, Unit::fixed, "N m", Availability::reactions, Figures::per_member,
     &RunResult::joint_moment, [](const Sample& s) { return s.joint_moment.data()->data(); }, &TermMagnitudes::joint_moment},
    {"constraint_force", "constraint_force", "force or moment that enforces the constraint on speeds", constraint, Shape::plain, Unit::constraint, "", Availability::reactions, Figures::per_member,
     &RunResult::constraint_force, [](const Sample& s) { return s.constraint_force.data(); }, &TermMagnitudes::constraint_force},
    {"constraint_power", "constraint_power", "power of the force that enforces the constraint on speeds", constraint, Shape::plain, Unit::fixed, "W", Availability::prescribed_speeds, Figures::per_member,
     &RunResult::constraint_power, [](const Sample& s) { return s.constraint_power.data(); }, &TermMagnitudes::constraint_power},
    {"kinetic_energy", "", "kinetic energy", single, Shape::plain, Unit::fixed, "J", Availability::always, Figures::whole,
     &RunResult::kinetic_energy, [](const Sample& s) { return &s.kinetic_energy; }, &TermMagnitudes::kinetic_energy},
    {"potential_energy", "", "potential energy of weight and springs", single, Shape::plain, Unit::fixed, "J", Availability::always, Figures::none,
     &RunResult::potential_energy, [](const Sample& s) { return &s.potential_energy; }, &TermMagnitudes::potential_energy},
    {"mobility", "", "smallest singular value of the scaled drive Jacobian; zero at a singularity", single, Shape::plain, Unit::fixed, "1", Availability::reactions, Figures::none,
     &RunResult::mobility, [](const Sample& s) { return &s.mobility; }, nullptr},
    {"desired_position", "desired", "joint coordinate of the desired motion", coordinate, Shape::plain, Unit::coordinate, "", Availability::tracking, Figures::none,
     &RunResult::desired_position, [](const Sample& s) { return s.desired_position.data(); }, &TermMagnitudes::position},
    {"tracking_error", "error", "tracking error of the joint coordinate, desired minus actual", coordinate, Shape::plain, Unit::coordinate, "", Availability::tracking, Figures::tracked,
     &RunResult::tracking_error, [](const Sample& s) { return s.tracking_error.data(); }, &TermMagnitudes::position},
    {"desired_tool_position", "", "tool of the desired motion", axis, Shape::plain, Unit::fixed, "m", Availability::tool_tracking, Figures::none,
     &RunResult::desired_tool_position, [](const Sample& s) { return s.desired_tool_position.data(); }, &TermMagnitudes::tool_position},
    {"tool_error", "", "tracking error of the tool, desired minus actual", axis, Shape::plain, Unit::fixed, "m", Availability::tool_tracking, Figures::whole,
     &RunResult::tool_error, [](const Sample& s) { return s.tool_error.data(); }, &TermMagnitudes::tool_position},
    {"tool_angle_error", "", "angle between the desired and the actual orientation of the tool", single, Shape::plain, Unit::fixed, "rad", Availability::tool_tracking, Figures::whole,
     &RunResult::tool_angle_error, [](const Sample& s) { return &s.tool_angle_error; }, &TermMagnitudes::tool_angle},
    {"sliding_variable", "sliding", "sliding variable, minus the rate of the error minus lambda times the error", sliding, Shape::plain, Unit::sliding, "", Availability::tracking, Figures::per_member_and_worst,
     &RunResult::sliding_variable, [](const Sample& s) { return s.sliding_variable.data(); }, &TermMagnitudes::sliding_variable},
    {"torque_variation", "torque_variation", "sum of all absolute changes of the torque so far", actuator, Shape::plain, Unit::actuator, "", Availability::control, Figures::per_member_and_worst,
     &RunResult::torque_variation, [](const Sample& s) { return s.torque_variation.data(); }, &TermMagnitudes::effort},
    {"saturation", "saturation", "1 while the torque is at its limit, else 0", actuator, Shape::plain, Unit::fixed, "1", Availability::control, Figures::per_member_and_worst,
     &RunResult::saturation, [](const Sample& s) { return s.saturation.data(); }, nullptr},
    {"torque_measured", "torque_measured", "measured torque or force of the actuator, low-passed", actuator, Shape::plain, Unit::actuator, "", Availability::measured, Figures::per_member_and_worst,
     &RunResult::torque_measured, nullptr, &TermMagnitudes::effort},
    {"torque_residual", "torque_residual", "measured minus computed torque or force of the actuator, both low-passed", actuator, Shape::plain, Unit::actuator, "", Availability::measured, Figures::per_member_and_worst,
     &RunResult::torque_residual, nullptr, &TermMagnitudes::effort},
    {"torque_inertia", "torque_inertia", "part of the torque that accelerates the independent coordinates", actuator, Shape::plain, Unit::actuator, "", Availability::split, Figures::none,
     &RunResult::torque_inertia, nullptr, &TermMagnitudes::effort},
    {"torque_velocity", "torque_velocity", "part of the torque due to rates: centrifugal and Coriolis terms", actuator, Shape::plain, Unit::actuator, "", Availability::split, Figures::none,
     &RunResult::torque_velocity, nullptr, &TermMagnitudes::effort},
    {"torque_friction", "torque_friction", "part of the torque that overcomes joint friction", actuator, Shape::plain, Unit::actuator, "", Availability::split, Figures::none,
     &RunResult::torque_friction, nullptr, &TermMagnitudes::effort},
    {"torque_weight", "torque_weight", "part of the torque that carries weight", actuator, Shape::plain, Unit::actuator, "", Availability::split, Figures::none,
     &RunResult::torque_weight, nullptr, &TermMagnitudes::effort},
    {"torque_spring", "torque_spring", "part of the torque that acts against springs", actuator, Shape::plain, Unit::actuator, "", Availability::split, Figures::none,
     &RunResult::torque_spring, nullptr, &TermMagnitudes::effort},
    {"torque_load", "torque_load", "part of the torque that acts against loads", actuator, Shape::plain, Unit::actuator, "", Availability::split, Figures::none,
     &RunResult::torque_load, nullptr, &TermMagnitudes::effort},
    {"body_position", "position", "origin of the body", body_axis, Shape::plain, Unit::fixed, "m", Availability::poses, Figures::none,
     &RunResult::body_position, nullptr, &TermMagnitudes::com_position},
    {"body_orientation", "orientation", "of the body", body, Shape::orientation, Unit::turn, "", Availability::poses, Figures::none,
     &RunResult::body_orientation, nullptr, nullptr},
};
// clang-format on

std::vector<std::string> append_suffix(const std::vector<std::string>& units, const char* suffix) {
  std::vector<std::string> result;
  for (const std::string& unit : units) result.push_back(unit + suffix);
  return result;
}

std::vector<std::string> units_of(const QuantityDefinition& kind, const RunResult& r) {
  switch (kind.unit_of) {
    case Unit::fixed: return {kind.unit};
    case Unit::coordinate: return append_suffix(r.coordinate_units, kind.unit);
    case Unit::constraint: return r.constraint_units;
    case Unit::sliding: return r.sliding_units;
    case Unit::turn: return {r.moment_axes == 1 ? "rad" : "1"};
    case Unit::actuator: break;
  }
  if (kind.columns != single) return r.actuator_units;
  return {r.actuator_units.empty() ? "1" : r.actuator_units.front()};
}

std::string long_name_of(const QuantityDefinition& kind, const RunResult& r) {
  const bool planar = r.moment_axes == 1;
  if (kind.shape == Shape::moment) return std::string(kind.long_name) + (planar ? ", counter-clockwise" : "");
  if (kind.shape == Shape::orientation)
    return planar ? std::string("angle ") + kind.long_name
                  : std::string("orientation ") + kind.long_name + " as unit quaternion";
  return kind.long_name;
}

}  // namespace

std::span<const QuantityDefinition> quantity_table() { return quantity_definitions; }

ColumnKind columns_of(const QuantityDefinition& kind, const RunResult& r) {
  const bool planar = r.moment_axes == 1;
  if (kind.shape == Shape::moment && planar) return kind.columns == joint_axis ? joint : single;
  if (kind.shape == Shape::orientation && !planar) return kind.columns == body ? body_quaternion : quaternion;
  return kind.columns;
}

Eigen::Index count_columns(ColumnKind columns, const RunResult& r) {
  const auto size = [](const std::vector<std::string>& names) { return static_cast<Eigen::Index>(names.size()); };
  switch (columns) {
    case single: return 1;
    case coordinate: return size(r.coordinate_names);
    case actuator: return size(r.actuator_names);
    case axis: return r.axes;
    case quaternion: return 4;
    case joint: return size(r.joint_names);
    case joint_axis: return size(r.joint_names) * r.axes;
    case constraint: return size(r.constraint_names);
    case sliding: return size(r.sliding_names);
    case body: return size(r.body_names);
    case body_axis: return size(r.body_names) * r.axes;
    case body_quaternion: return size(r.body_names) * 4;
  }
  return 0;
}

std::vector<std::string> axis_labels(int axes) {
  const std::vector<std::string> labels = {"x", "y", "z"};
  return {labels.begin(), labels.begin() + axes};
}

std::vector<std::string> quaternion_labels() { return {"w", "x", "y", "z"}; }

std::string common_unit(const std::vector<std::string>& units) {
  if (units.empty()) return "1";
  const bool is_uniform =
      std::all_of(units.begin(), units.end(), [&](const auto& unit) { return unit == units.front(); });
  return is_uniform ? units.front() : "mixed";
}

std::vector<Quantity> list_all_quantities(const RunResult& r) {
  std::vector<Quantity> quantities;
  for (const QuantityDefinition& kind : quantity_definitions)
    quantities.push_back({kind.name, kind.short_name, long_name_of(kind, r), units_of(kind, r), columns_of(kind, r),
                          kind.has_moment_reference, kind.member, &(r.*kind.member)});
  return quantities;
}

std::vector<Quantity> list_sampled_quantities(const RunResult& r) {
  std::vector<Quantity> quantities = list_all_quantities(r);
  std::erase_if(quantities, [](const Quantity& quantity) { return quantity.samples->size() == 0; });
  return quantities;
}

}  // namespace balance::results
