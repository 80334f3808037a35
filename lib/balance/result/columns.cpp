#include "balance/result/columns.hpp"

namespace balance {

void name_columns(const Mechanism& mechanism, Result& result) {
  const bool planar = mechanism.space == SpaceKind::planar;
  result.axes = planar ? 2 : 3;
  result.moment_axes = planar ? 1 : 3;
  for (const Coordinate& coordinate : mechanism.coordinates) {
    result.coordinate_names.push_back(coordinate.name);
    result.coordinate_units.push_back(coordinate.kind == CoordinateKind::angle ? "rad" : "m");
  }
  for (const Joint& joint : mechanism.joints) result.joint_names.push_back(joint.name);
  for (const int actuator : mechanism.actuators) {
    result.actuator_names.push_back(mechanism.coordinates[actuator].name);
    result.actuator_units.push_back(mechanism.coordinates[actuator].kind == CoordinateKind::angle ? "N m" : "N");
  }
}

void size_arrays(const Mechanism& mechanism, long rows, Contents contents, Result& result) {
  const auto C = static_cast<Eigen::Index>(result.coordinate_names.size());
  const auto A = static_cast<Eigen::Index>(result.actuator_names.size());
  const auto J = static_cast<Eigen::Index>(result.joint_names.size());
  result.time.resize(rows);
  for (auto* array : {&result.joint_position, &result.joint_velocity, &result.joint_acceleration})
    array->resize(rows, C);
  for (auto* array : {&result.torque, &result.power}) array->resize(rows, A);
  for (auto* array : {&result.com_position, &result.com_velocity, &result.com_acceleration, &result.shaking_force,
                      &result.ground_force})
    array->resize(rows, result.axes);
  for (auto* array : {&result.shaking_moment, &result.ground_moment}) array->resize(rows, result.moment_axes);
  for (auto* array : {&result.kinetic_energy, &result.potential_energy}) array->resize(rows, 1);
  if (contents == Contents::everything) {
    result.joint_force.resize(rows, J * result.axes);
    result.joint_moment.resize(rows, J * result.moment_axes);
    result.mobility.resize(rows, 1);
  }
  result.newton_iterations.resize(rows);
  if (!mechanism.tool) return;
  result.tool_position.resize(rows, result.axes);
  result.tool_orientation.resize(rows, mechanism.space == SpaceKind::planar ? 1 : 4);
}

}  // namespace balance
