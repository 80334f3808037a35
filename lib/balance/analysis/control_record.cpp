#include "balance/analysis/control_record.hpp"

#include "balance/base/elementary.hpp"
#include "balance/base/rotation.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace balance {

void ClosedLoopRecorder::allocate_rows(long rows, const Vector3& about, RunResult& result) const {
  name_columns(mechanism_, result);
  const bool wanted = desired_.outcome.status == MotionStatus::done;
  for (const int c : law_.sliding_coordinates()) {
    const Coordinate& coordinate = mechanism_.coordinates[static_cast<std::size_t>(c)];
    result.sliding_names.push_back(coordinate.name);
    result.sliding_units.push_back(coordinate.kind == CoordinateKind::angle ? "rad/s" : "m/s");
  }
  result.moment_reference = about;
  resize_arrays(mechanism_, rows, {.control = true, .tracking = wanted}, result);
}

void ClosedLoopRecorder::write_row(const Sample& seen, const ControllerState& state, double time, Eigen::Index event,
                                   long row, RunResult& result) {
  if (!recorder_) recorder_.emplace(result);
  sample_ = seen;
  sample_.time = time;
  sample_.torque_variation = state.variation;
  sample_.saturation = state.saturated;
  if (sample_.saturation.size() == 0) sample_.saturation.setZero(sample_.effort.size());
  if (result.tracking_error.size() > 0) write_tracking_errors(event);
  recorder_->write(sample_, row, result);
}

/// With the desired motion.
void ClosedLoopRecorder::write_tracking_errors(Eigen::Index event) {
  Sample& s = sample_;
  s.desired_position = desired_.position.row(event);
  s.tracking_error = s.desired_position - s.position;
  const auto& motors = mechanism_.actuators;
  for (std::size_t i = 0; i < mechanism_.coordinates.size(); ++i) {
    // Of a coordinate without a motor, whole turns do not count: they are read off, not driven.
    double& error = s.tracking_error[static_cast<Eigen::Index>(i)];
    if (mechanism_.coordinates[i].kind == CoordinateKind::angle &&
        std::find(motors.begin(), motors.end(), static_cast<int>(i)) == motors.end())
      error = std::remainder(error, 2 * std::numbers::pi);
  }
  s.sliding_variable.resize(static_cast<Eigen::Index>(law_.sliding_coordinates().size()));
  for (std::size_t i = 0; i < law_.sliding_coordinates().size(); ++i) {
    const Eigen::Index c = law_.sliding_coordinates()[i], k = static_cast<Eigen::Index>(i);
    s.sliding_variable[k] =
        s.velocity[c] - desired_.velocity(event, c) - law_.sliding_lambda()[k] * s.tracking_error[c];
  }
  if (!mechanism_.tool) return;
  s.desired_tool_position = desired_.tool_position.row(event);
  s.tool_error = s.desired_tool_position - s.tool_position;
  if (mechanism_.space == SpaceKind::planar) {
    s.tool_angle_error = desired_.tool_angle[event] - s.tool_angle;
    return;
  }
  const Matrix3 gap = desired_.tool_rotation[static_cast<std::size_t>(event)] * s.tool_rotation.transpose();
  const Eigen::Vector4d turn = quaternion_of(gap);
  s.tool_angle_error = 2 * elementary::atan2(turn.tail<3>().norm(), std::abs(turn[0]));
}

}  // namespace balance
