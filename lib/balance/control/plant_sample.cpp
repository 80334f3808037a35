#include "balance/control/plant_sample.hpp"

namespace balance {

namespace {

Eigen::Map<const VectorX> vector(const std::vector<double>& values) {
  return {values.data(), static_cast<Eigen::Index>(values.size())};
}

}  // namespace

template <class S>
void copy_observation(const Observation<S>& seen, PlantSample& sample) {
  sample.position = vector(seen.position);
  sample.velocity = vector(seen.velocity);
  sample.acceleration = vector(seen.acceleration);
  sample.effort = vector(seen.effort);
  sample.power = vector(seen.power);
  sample.com = to_3d(seen.com);
  sample.com_velocity = to_3d(seen.com_velocity);
  sample.com_acceleration = to_3d(seen.com_acceleration);
  sample.tool_position = to_3d(seen.tool_position);
  sample.tool_rotation = to_matrix(seen.tool_rotation);
  sample.tool_angle = seen.tool_angle;
  sample.shaking_force = to_3d(seen.shaking_force);
  sample.shaking_moment = angular_to_3d(seen.shaking_moment);
  sample.ground_force = to_3d(seen.ground_force);
  sample.ground_moment = angular_to_3d(seen.ground_moment);
  sample.joint_force.resize(seen.joint_force.size());
  sample.joint_moment.resize(seen.joint_moment.size());
  for (std::size_t j = 0; j < seen.joint_force.size(); ++j) {
    sample.joint_force[j] = to_3d(seen.joint_force[j]);
    sample.joint_moment[j] = angular_to_3d(seen.joint_moment[j]);
  }
  sample.kinetic_energy = seen.kinetic_energy;
  sample.potential_energy = seen.potential_energy;
}

template void copy_observation<Planar>(const Observation<Planar>&, PlantSample&);
template void copy_observation<Spatial>(const Observation<Spatial>&, PlantSample&);

}  // namespace balance
