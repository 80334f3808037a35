#include "balance/result/rows.hpp"

#include "balance/result/quantities.hpp"

namespace balance {

void size_control_rows(const Mechanism& mechanism, long rows, Wanted wanted, Result& result) {
  const auto C = static_cast<Eigen::Index>(result.coordinate_names.size());
  const auto A = static_cast<Eigen::Index>(result.actuator_names.size());
  for (auto* array : {&result.torque_variation, &result.saturation}) array->setZero(rows, A);
  if (wanted == Wanted::unknown) return;
  for (auto* array : {&result.desired_position, &result.tracking_error}) array->setZero(rows, C);
  result.sliding_variable.setZero(rows, static_cast<Eigen::Index>(result.sliding_names.size()));
  if (!mechanism.tool) return;
  for (auto* array : {&result.desired_tool_position, &result.tool_error}) array->setZero(rows, result.axes);
  result.tool_angle_error.setZero(rows, 1);
}

void cut_rows(long rows, Result& result) {
  result.time.conservativeResize(rows);
  if (result.newton_iterations.size() > 0) result.newton_iterations.conservativeResize(rows);
  for (const Quantity& quantity : all_quantities(result)) {
    Samples& samples = result.*quantity.member;
    if (samples.size() > 0) samples.conservativeResize(rows, Eigen::NoChange);
  }
}

}  // namespace balance
