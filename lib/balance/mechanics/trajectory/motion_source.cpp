#include "balance/mechanics/trajectory/motion_source.hpp"

#include <algorithm>

namespace balance::trajectory {

MotionTable sample_motion(const Mechanism& mechanism, MotionSource& source, const std::vector<double>& times) {
  MotionTable table;
  table.outcome = source.outcome();
  if (table.outcome.status != MotionStatus::done) return table;
  table.duration = source.prescribed_motion().duration();
  const auto rows = static_cast<Eigen::Index>(times.size());
  for (Samples* array : {&table.position, &table.velocity, &table.acceleration})
    array->setZero(rows, static_cast<Eigen::Index>(mechanism.coordinates.size()));
  const bool is_planar = mechanism.space == SpaceKind::planar;
  if (mechanism.tool) {
    table.tool_position.setZero(rows, 3);
    if (is_planar) table.tool_angle.setZero(rows);
    if (!is_planar) table.tool_rotation.resize(times.size());
  }
  const auto record = [&](bool is_break) {
    if (is_break) return;
    source.evaluate();
    const Sample& sample = source.sample();
    const Eigen::Index row = table.rows++;
    table.position.row(row) = sample.position;
    if (times[static_cast<std::size_t>(row)] <= table.duration * (1 + 1e-12)) {
      table.velocity.row(row) = sample.velocity;
      table.acceleration.row(row) = sample.acceleration;
    }
    if (!mechanism.tool) return;
    table.tool_position.row(row) = sample.tool_position;
    if (is_planar) table.tool_angle[row] = sample.tool_angle;
    if (!is_planar) table.tool_rotation[static_cast<std::size_t>(row)] = sample.tool_rotation;
  };
  std::vector<double> reached = times;
  for (double& time : reached) time = std::min(time, table.duration);
  if (!visit_times(source, source.prescribed_motion().jump_times(), reached, record)) table.outcome = source.outcome();
  return table;
}

}  // namespace balance::trajectory
