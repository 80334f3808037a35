#include "balance/analysis/start_pose.hpp"

#include "balance/kinematics/joint_coordinates.hpp"
#include "balance/motion/plan.hpp"

namespace balance {

namespace {

template <class S>
std::vector<CoordinateValue> find(const Mechanism& mechanism, const Trajectory& trajectory) {
  const Tree<S> tree = compile<S>(mechanism, prescribed_coordinates(trajectory));
  const PoseEquations<S> from = pose_equations(mechanism, tree, trajectory.from);
  System<S> system(tree, from.drive);
  const Solution start = find_pose(mechanism, tree, system, from.target);
  std::vector<CoordinateValue> values;
  if (!start.found) return values;
  const std::vector<double> coordinates = read_coordinates(mechanism, tree, start.y);
  for (std::size_t c = 0; c < coordinates.size(); ++c) values.push_back({static_cast<int>(c), coordinates[c]});
  return values;
}

}  // namespace

std::vector<CoordinateValue> start_coordinates(const Study& study) {
  if (study.trajectories.empty()) return {};
  const Trajectory& trajectory = study.trajectories.front();
  return in_space(study.mechanism.space, [&]<class S>(S) { return find<S>(study.mechanism, trajectory); });
}

Mechanism assembled_at(Mechanism mechanism, const std::vector<CoordinateValue>& coordinates) {
  if (!coordinates.empty()) mechanism.assembly = coordinates;
  return mechanism;
}

}  // namespace balance
