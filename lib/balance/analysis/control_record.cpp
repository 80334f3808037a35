#include "balance/analysis/control_record.hpp"

#include "balance/base/rotation.hpp"
#include "balance/result/columns.hpp"
#include "balance/result/rows.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace balance {

namespace {

void put_vector(Samples& array, long row, const Vector3& v, int first, int count) {
  for (int i = 0; i < count; ++i) array(row, first + i) = v[count == 1 ? 2 : i];
}

}  // namespace

void ControlRecord::shape(long rows, const Vector3& about, Result& result) const {
  name_columns(mechanism_, result);
  const bool wanted = desired_.outcome.status == MotionStatus::done;
  for (const int c : law_.sliding()) {
    const Coordinate& coordinate = mechanism_.coordinates[static_cast<std::size_t>(c)];
    result.sliding_names.push_back(coordinate.name);
    result.sliding_units.push_back(coordinate.kind == CoordinateKind::angle ? "rad/s" : "m/s");
  }
  result.about = about;
  size_arrays(mechanism_, rows, Contents::everything, result);
  size_control_rows(mechanism_, rows, wanted ? Wanted::known : Wanted::unknown, result);
}

void ControlRecord::write(const PlantSample& seen, const ControllerState& state, double time, Eigen::Index event,
                          long row, Result& result) {
  const int axes = result.axes, turns = result.moment_axes;
  result.time[row] = time;
  result.joint_position.row(row) = seen.position;
  result.joint_velocity.row(row) = seen.velocity;
  result.joint_acceleration.row(row) = seen.acceleration;
  result.torque.row(row) = seen.effort;
  result.power.row(row) = seen.power;
  put_vector(result.com_position, row, seen.com, 0, axes);
  put_vector(result.com_velocity, row, seen.com_velocity, 0, axes);
  put_vector(result.com_acceleration, row, seen.com_acceleration, 0, axes);
  put_vector(result.shaking_force, row, seen.shaking_force, 0, axes);
  put_vector(result.shaking_moment, row, seen.shaking_moment, 0, turns);
  put_vector(result.ground_force, row, seen.ground_force, 0, axes);
  put_vector(result.ground_moment, row, seen.ground_moment, 0, turns);
  for (std::size_t j = 0; j < seen.joint_force.size(); ++j) {
    put_vector(result.joint_force, row, seen.joint_force[j], static_cast<int>(j) * axes, axes);
    put_vector(result.joint_moment, row, seen.joint_moment[j], static_cast<int>(j) * turns, turns);
  }
  result.kinetic_energy(row, 0) = seen.kinetic_energy;
  result.potential_energy(row, 0) = seen.potential_energy;
  result.mobility(row, 0) = seen.mobility;
  result.newton_iterations[row] = seen.newton_iterations;
  result.torque_variation.row(row) = state.variation;
  if (state.saturated.size() > 0) result.saturation.row(row) = state.saturated;
  if (mechanism_.tool) write_tool(result, row, seen);
  if (result.tracking_error.size() > 0) write_errors(result, row, event, seen);
}

void ControlRecord::write_errors(Result& result, long row, Eigen::Index event, const PlantSample& seen) {
  result.desired_position.row(row) = desired_.position.row(event);
  for (std::size_t i = 0; i < mechanism_.coordinates.size(); ++i) {
    const auto c = static_cast<Eigen::Index>(i);
    double error = desired_.position(event, c) - seen.position[c];
    // Of a coordinate without a motor, whole turns do not count: they are read off, not driven.
    const auto& motors = mechanism_.actuators;
    if (mechanism_.coordinates[i].kind == CoordinateKind::angle &&
        std::find(motors.begin(), motors.end(), static_cast<int>(i)) == motors.end())
      error = std::remainder(error, 2 * std::numbers::pi);
    result.tracking_error(row, c) = error;
  }
  for (std::size_t i = 0; i < law_.sliding().size(); ++i) {
    const Eigen::Index c = law_.sliding()[i], column = static_cast<Eigen::Index>(i);
    result.sliding_variable(row, column) =
        seen.velocity[c] - desired_.velocity(event, c) - law_.sliding_lambda()[column] * result.tracking_error(row, c);
  }
  if (!mechanism_.tool) return;
  const Vector3 wanted = desired_.tool_position.row(event);
  put_vector(result.desired_tool_position, row, wanted, 0, result.axes);
  put_vector(result.tool_error, row, wanted - seen.tool_position, 0, result.axes);
  if (mechanism_.space == SpaceKind::planar) {
    result.tool_angle_error(row, 0) = desired_.tool_angle[event] - seen.tool_angle;
    return;
  }
  const Matrix3 gap = desired_.tool_rotation[static_cast<std::size_t>(event)] * seen.tool_rotation.transpose();
  const Eigen::Vector4d turn = quaternion_of(gap);
  result.tool_angle_error(row, 0) = 2 * std::atan2(turn.tail<3>().norm(), std::abs(turn[0]));
}

void ControlRecord::write_tool(Result& result, long row, const PlantSample& seen) {
  put_vector(result.tool_position, row, seen.tool_position, 0, result.axes);
  if (mechanism_.space == SpaceKind::planar) {
    result.tool_orientation(row, 0) = seen.tool_angle;
    return;
  }
  Eigen::Vector4d q = quaternion_of(seen.tool_rotation);
  // Of the two signs the one that goes on smoothly.
  if (last_quaternion_.dot(q) < 0) q = -q;
  last_quaternion_ = q;
  result.tool_orientation.row(row) = q;
}

}  // namespace balance
