#include "balance/gradients/over_duals.hpp"

namespace balance {

Sample derivative_of(const SampleOf<DualNumber>& sample, std::size_t k) {
  const auto number = [k](const DualNumber& x) { return x.d[k]; };
  const auto numbers = [&](const auto& x) { return x.unaryExpr(number).eval(); };
  const auto vectors = [&](const std::vector<Vector3Of<DualNumber>>& list) {
    std::vector<Vector3> out;
    for (const auto& v : list) out.emplace_back(numbers(v));
    return out;
  };
  Sample out;
  out.time = number(sample.time);
  out.position = numbers(sample.position);
  out.velocity = numbers(sample.velocity);
  out.acceleration = numbers(sample.acceleration);
  out.effort = numbers(sample.effort);
  out.power = numbers(sample.power);
  out.com = numbers(sample.com);
  out.com_velocity = numbers(sample.com_velocity);
  out.com_acceleration = numbers(sample.com_acceleration);
  out.tool_position = numbers(sample.tool_position);
  out.tool_rotation = numbers(sample.tool_rotation);
  out.tool_angle = number(sample.tool_angle);
  out.shaking_force = numbers(sample.shaking_force);
  out.shaking_moment = numbers(sample.shaking_moment);
  out.shaking_moment_com = numbers(sample.shaking_moment_com);
  out.ground_force = numbers(sample.ground_force);
  out.ground_moment = numbers(sample.ground_moment);
  out.joint_force = vectors(sample.joint_force);
  out.joint_moment = vectors(sample.joint_moment);
  out.kinetic_energy = number(sample.kinetic_energy);
  out.potential_energy = number(sample.potential_energy);
  out.total_torque = number(sample.total_torque);
  out.mobility = number(sample.mobility);
  return out;
}

}  // namespace balance
