#include "balance/model/incidence.hpp"

namespace balance {

std::vector<std::vector<JointId>> joints_of_bodies(const Mechanism& mechanism) {
  std::vector<std::vector<JointId>> joints(mechanism.bodies.size());
  for (std::size_t j = 0; j < mechanism.joints.size(); ++j) {
    const Joint& joint = mechanism.joints[j];
    joints[joint.first].push_back(static_cast<int>(j));
    if (joint.second != joint.first) joints[joint.second].push_back(static_cast<int>(j));
  }
  return joints;
}

std::vector<std::vector<CoordinateId>> coordinates_of_joints(const Mechanism& mechanism) {
  std::vector<std::vector<CoordinateId>> coordinates(mechanism.joints.size());
  for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c)
    coordinates[mechanism.coordinates[c].joint].push_back(static_cast<int>(c));
  return coordinates;
}

}  // namespace balance
