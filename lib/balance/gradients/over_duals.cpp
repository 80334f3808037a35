#include "balance/gradients/over_duals.hpp"

namespace balance {

void write_derivative(const SampleOf<DualNumber>& sample, std::size_t k, DerivativeDetail extent, Sample& out) {
  const auto number = [k](const DualNumber& x, double& to) { to = x.d[k]; };
  const auto numbers = [k](const auto& from, auto& to) {
    to.resize(from.rows(), from.cols());
    for (Eigen::Index i = 0; i < from.size(); ++i) to(i) = from(i).d[k];
  };
  const auto vectors = [&](const auto& from, std::vector<Vector3>& to) {
    to.resize(from.size());
    for (std::size_t i = 0; i < from.size(); ++i) numbers(from[i], to[i]);
  };
  number(sample.time, out.time);
  numbers(sample.effort, out.effort);
  numbers(sample.power, out.power);
  numbers(sample.com_acceleration, out.com_acceleration);
  numbers(sample.shaking_force, out.shaking_force);
  numbers(sample.shaking_moment, out.shaking_moment);
  numbers(sample.ground_force, out.ground_force);
  numbers(sample.ground_moment, out.ground_moment);
  if (extent == DerivativeDetail::forces) return;
  numbers(sample.com_velocity, out.com_velocity);
  numbers(sample.shaking_moment_com, out.shaking_moment_com);
  vectors(sample.joint_force, out.joint_force);
  vectors(sample.joint_moment, out.joint_moment);
  number(sample.kinetic_energy, out.kinetic_energy);
  number(sample.total_torque, out.total_torque);
  number(sample.mobility, out.mobility);
  if (extent == DerivativeDetail::figures) return;
  numbers(sample.position, out.position);
  numbers(sample.velocity, out.velocity);
  numbers(sample.acceleration, out.acceleration);
  numbers(sample.com, out.com);
  numbers(sample.tool_position, out.tool_position);
  numbers(sample.tool_rotation, out.tool_rotation);
  number(sample.tool_angle, out.tool_angle);
  number(sample.potential_energy, out.potential_energy);
}

Sample derivative_of(const SampleOf<DualNumber>& sample, std::size_t k) {
  Sample out;
  write_derivative(sample, k, DerivativeDetail::all, out);
  return out;
}

}  // namespace balance
