#include "balance/result/quantities.hpp"

#include <algorithm>
#include <iterator>

namespace balance {
namespace {

using enum Columns;
using Shape = QuantityKind::Shape;
using Unit = QuantityKind::Unit;
using Figures = QuantityKind::Figures;

constexpr const char* about_its_point =
    "reaction moment of the joint on its second body, about the joint's point on it";
constexpr const char* about_moving_com = "rate of the total angular momentum about the moving centre of mass";

// clang-format off
constexpr QuantityKind table[] = {
    {"joint_position", "position", "joint coordinate", coordinate, Shape::plain, Unit::coordinate, "", Occasion::always, Figures::none,
     &Result::joint_position, [](const Sample& s) { return s.position.data(); }, &TermSizes::position},
    {"joint_velocity", "velocity", "rate of the joint coordinate", coordinate, Shape::plain, Unit::coordinate, "/s", Occasion::always, Figures::none,
     &Result::joint_velocity, [](const Sample& s) { return s.velocity.data(); }, &TermSizes::velocity},
    {"joint_acceleration", "acceleration", "second rate of the joint coordinate", coordinate, Shape::plain, Unit::coordinate, "/s^2", Occasion::always, Figures::none,
     &Result::joint_acceleration, [](const Sample& s) { return s.acceleration.data(); }, &TermSizes::acceleration},
    {"torque", "torque", "torque or force of the actuator", actuator, Shape::plain, Unit::actuator, "", Occasion::always, Figures::and_worst,
     &Result::torque, [](const Sample& s) { return s.effort.data(); }, &TermSizes::effort},
    {"total_torque", "", "root of the sum of the actuators' squared torques or forces", single, Shape::plain, Unit::actuator, "", Occasion::like_motors, Figures::whole,
     &Result::total_torque, [](const Sample& s) { return &s.total_torque; }, &TermSizes::total_effort},
    {"power", "power", "power of the actuator", actuator, Shape::plain, Unit::fixed, "W", Occasion::always, Figures::and_worst,
     &Result::power, [](const Sample& s) { return s.power.data(); }, &TermSizes::power},
    {"com_position", "", "centre of mass of all moving bodies", axis, Shape::plain, Unit::fixed, "m", Occasion::always, Figures::none,
     &Result::com_position, [](const Sample& s) { return s.com.data(); }, &TermSizes::com_position},
    {"com_velocity", "", "velocity of the centre of mass", axis, Shape::plain, Unit::fixed, "m/s", Occasion::always, Figures::whole,
     &Result::com_velocity, [](const Sample& s) { return s.com_velocity.data(); }, &TermSizes::com_velocity},
    {"com_acceleration", "", "acceleration of the centre of mass", axis, Shape::plain, Unit::fixed, "m/s^2", Occasion::always, Figures::whole,
     &Result::com_acceleration, [](const Sample& s) { return s.com_acceleration.data(); }, &TermSizes::com_acceleration},
    {"tool_position", "", "position of the tool", axis, Shape::plain, Unit::fixed, "m", Occasion::tool, Figures::none,
     &Result::tool_position, [](const Sample& s) { return s.tool_position.data(); }, &TermSizes::tool_position},
    {"tool_orientation", "", "of the tool", single, Shape::turn, Unit::turn, "", Occasion::tool, Figures::none,
     &Result::tool_orientation, [](const Sample& s) { return &s.tool_angle; }, &TermSizes::tool_angle},
    {"shaking_force", "", "shaking force: rate of the total linear momentum", axis, Shape::plain, Unit::fixed, "N", Occasion::always, Figures::whole,
     &Result::shaking_force, [](const Sample& s) { return s.shaking_force.data(); }, &TermSizes::shaking_force},
    {"shaking_moment", "", "shaking moment: rate of the total angular momentum", axis, Shape::moment, Unit::fixed, "N m", Occasion::always, Figures::whole,
     &Result::shaking_moment, [](const Sample& s) { return s.shaking_moment.data(); }, &TermSizes::shaking_moment, true},
    {"shaking_moment_com", "", about_moving_com, axis, Shape::moment, Unit::fixed, "N m", Occasion::always, Figures::whole,
     &Result::shaking_moment_com, [](const Sample& s) { return s.shaking_moment_com.data(); }, &TermSizes::moment_com},
    {"ground_force", "", "force on the frame, weight included", axis, Shape::plain, Unit::fixed, "N", Occasion::always, Figures::whole,
     &Result::ground_force, [](const Sample& s) { return s.ground_force.data(); }, &TermSizes::force},
    {"ground_moment", "", "moment on the frame, weight included", axis, Shape::moment, Unit::fixed, "N m", Occasion::always, Figures::whole,
     &Result::ground_moment, [](const Sample& s) { return s.ground_moment.data(); }, &TermSizes::moment, true},
    {"joint_force", "force", "reaction force of the joint on its second body", joint_axis, Shape::plain, Unit::fixed, "N", Occasion::reactions, Figures::each,
     &Result::joint_force, [](const Sample& s) { return s.joint_force.data()->data(); }, &TermSizes::joint_force},
    {"joint_moment", "moment", about_its_point, joint_axis, Shape::moment, Unit::fixed, "N m", Occasion::reactions, Figures::each,
     &Result::joint_moment, [](const Sample& s) { return s.joint_moment.data()->data(); }, &TermSizes::joint_moment},
    {"constraint_force", "constraint_force", "force or moment that keeps the constraint on speeds", constraint, Shape::plain, Unit::constraint, "", Occasion::reactions, Figures::each,
     &Result::constraint_force, [](const Sample& s) { return s.constraint_force.data(); }, &TermSizes::constraint_force},
    {"kinetic_energy", "", "kinetic energy", single, Shape::plain, Unit::fixed, "J", Occasion::always, Figures::whole,
     &Result::kinetic_energy, [](const Sample& s) { return &s.kinetic_energy; }, &TermSizes::kinetic_energy},
    {"potential_energy", "", "potential energy of weight and springs", single, Shape::plain, Unit::fixed, "J", Occasion::always, Figures::none,
     &Result::potential_energy, [](const Sample& s) { return &s.potential_energy; }, &TermSizes::potential_energy},
    {"mobility", "", "smallest singular value of the scaled drive Jacobian; zero at a singularity", single, Shape::plain, Unit::fixed, "1", Occasion::reactions, Figures::none,
     &Result::mobility, [](const Sample& s) { return &s.mobility; }, nullptr},
    {"desired_position", "desired", "joint coordinate of the desired motion", coordinate, Shape::plain, Unit::coordinate, "", Occasion::tracking, Figures::none,
     &Result::desired_position, [](const Sample& s) { return s.desired_position.data(); }, &TermSizes::position},
    {"tracking_error", "error", "tracking error of the joint coordinate, desired minus actual", coordinate, Shape::plain, Unit::coordinate, "", Occasion::tracking, Figures::tracked,
     &Result::tracking_error, [](const Sample& s) { return s.tracking_error.data(); }, &TermSizes::position},
    {"desired_tool_position", "", "tool of the desired motion", axis, Shape::plain, Unit::fixed, "m", Occasion::tool_tracking, Figures::none,
     &Result::desired_tool_position, [](const Sample& s) { return s.desired_tool_position.data(); }, &TermSizes::tool_position},
    {"tool_error", "", "tracking error of the tool, desired minus actual", axis, Shape::plain, Unit::fixed, "m", Occasion::tool_tracking, Figures::whole,
     &Result::tool_error, [](const Sample& s) { return s.tool_error.data(); }, &TermSizes::tool_position},
    {"tool_angle_error", "", "angle between the desired and the actual orientation of the tool", single, Shape::plain, Unit::fixed, "rad", Occasion::tool_tracking, Figures::whole,
     &Result::tool_angle_error, [](const Sample& s) { return &s.tool_angle_error; }, &TermSizes::tool_angle},
    {"sliding_variable", "sliding", "sliding variable, minus the rate of the error minus lambda times the error", sliding, Shape::plain, Unit::sliding, "", Occasion::tracking, Figures::and_worst,
     &Result::sliding_variable, [](const Sample& s) { return s.sliding_variable.data(); }, &TermSizes::sliding_variable},
    {"torque_variation", "torque_variation", "sum of all changes of the torque so far, without sign", actuator, Shape::plain, Unit::actuator, "", Occasion::control, Figures::and_worst,
     &Result::torque_variation, [](const Sample& s) { return s.torque_variation.data(); }, &TermSizes::effort},
    {"saturation", "saturation", "1 while the torque is cut by its limit, else 0", actuator, Shape::plain, Unit::fixed, "1", Occasion::control, Figures::and_worst,
     &Result::saturation, [](const Sample& s) { return s.saturation.data(); }, nullptr},
    {"torque_inertia", "torque_inertia", "part of the torque that accelerates the independent coordinates", actuator, Shape::plain, Unit::actuator, "", Occasion::split, Figures::none,
     &Result::torque_inertia, nullptr, &TermSizes::effort},
    {"torque_velocity", "torque_velocity", "part of the torque that rates ask for: centrifugal and Coriolis terms", actuator, Shape::plain, Unit::actuator, "", Occasion::split, Figures::none,
     &Result::torque_velocity, nullptr, &TermSizes::effort},
    {"torque_friction", "torque_friction", "part of the torque that joint friction takes", actuator, Shape::plain, Unit::actuator, "", Occasion::split, Figures::none,
     &Result::torque_friction, nullptr, &TermSizes::effort},
    {"torque_weight", "torque_weight", "part of the torque that carries weight", actuator, Shape::plain, Unit::actuator, "", Occasion::split, Figures::none,
     &Result::torque_weight, nullptr, &TermSizes::effort},
    {"torque_spring", "torque_spring", "part of the torque that acts against springs", actuator, Shape::plain, Unit::actuator, "", Occasion::split, Figures::none,
     &Result::torque_spring, nullptr, &TermSizes::effort},
    {"torque_load", "torque_load", "part of the torque that acts against loads", actuator, Shape::plain, Unit::actuator, "", Occasion::split, Figures::none,
     &Result::torque_load, nullptr, &TermSizes::effort},
    {"body_position", "position", "origin of the body", body_axis, Shape::plain, Unit::fixed, "m", Occasion::poses, Figures::none,
     &Result::body_position, nullptr, &TermSizes::com_position},
    {"body_orientation", "orientation", "of the body", body, Shape::turn, Unit::turn, "", Occasion::poses, Figures::none,
     &Result::body_orientation, nullptr, nullptr},
};
// clang-format on

std::vector<std::string> with(const std::vector<std::string>& units, const char* suffix) {
  std::vector<std::string> result;
  for (const std::string& unit : units) result.push_back(unit + suffix);
  return result;
}

std::vector<std::string> units_of(const QuantityKind& kind, const Result& r) {
  switch (kind.unit_of) {
    case Unit::fixed: return {kind.unit};
    case Unit::coordinate: return with(r.coordinate_units, kind.unit);
    case Unit::constraint: return r.constraint_units;
    case Unit::sliding: return r.sliding_units;
    case Unit::turn: return {r.moment_axes == 1 ? "rad" : "1"};
    case Unit::actuator: break;
  }
  if (kind.columns != single) return r.actuator_units;
  return {r.actuator_units.empty() ? "1" : r.actuator_units.front()};
}

std::string long_name_of(const QuantityKind& kind, const Result& r) {
  const bool planar = r.moment_axes == 1;
  if (kind.shape == Shape::moment) return std::string(kind.long_name) + (planar ? ", counter-clockwise" : "");
  if (kind.shape == Shape::turn)
    return planar ? std::string("angle ") + kind.long_name
                  : std::string("orientation ") + kind.long_name + " as unit quaternion";
  return kind.long_name;
}

}  // namespace

std::span<const QuantityKind> quantity_table() { return table; }

Columns columns_of(const QuantityKind& kind, const Result& r) {
  const bool planar = r.moment_axes == 1;
  if (kind.shape == Shape::moment && planar) return kind.columns == joint_axis ? joint : single;
  if (kind.shape == Shape::turn && !planar) return kind.columns == body ? body_quaternion : quaternion;
  return kind.columns;
}

Eigen::Index count_columns(Columns columns, const Result& r) {
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
  std::vector<Quantity> all;
  for (const QuantityKind& kind : table)
    all.push_back({kind.name, kind.short_name, long_name_of(kind, r), units_of(kind, r), columns_of(kind, r),
                   kind.about, kind.member, &(r.*kind.member)});
  return all;
}

std::vector<Quantity> list_quantities(const Result& r) {
  std::vector<Quantity> all = all_quantities(r);
  std::erase_if(all, [](const Quantity& quantity) { return quantity.samples->size() == 0; });
  return all;
}

}  // namespace balance
