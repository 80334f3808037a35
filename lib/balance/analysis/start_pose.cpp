#include "balance/analysis/start_pose.hpp"

#include "balance/kinematics/joint_coordinates.hpp"
#include "balance/motion/plan.hpp"

namespace balance {

namespace {

template <class S>
std::vector<CoordinateValue> find_start_coordinates(const Mechanism& mechanism, const Trajectory& trajectory) {
  const Tree<S> tree = compile_tree<S>(mechanism, prescribed_coordinates(trajectory));
  const PoseEquations<S> from = make_pose_equations(mechanism, tree, trajectory.from);
  ConstraintSystem<S> system(tree, from.drive);
  const AssemblySolution start = solve_pose(mechanism, tree, system, from.target);
  std::vector<CoordinateValue> values;
  if (!start.found) return values;
  const std::vector<double> coordinates = compute_coordinates(mechanism, tree, start.y);
  for (std::size_t c = 0; c < coordinates.size(); ++c) values.push_back({static_cast<int>(c), coordinates[c]});
  return values;
}

}  // namespace

std::vector<CoordinateValue> start_coordinates(const Study& study) {
  if (study.trajectories.empty()) return {};
  const Trajectory& trajectory = study.trajectories.front();
  return dispatch_space(study.mechanism.space,
                        [&]<class S>(S) { return find_start_coordinates<S>(study.mechanism, trajectory); });
}

Mechanism assembled_at(Mechanism mechanism, const std::vector<CoordinateValue>& coordinates) {
  if (!coordinates.empty()) mechanism.assembly = coordinates;
  return mechanism;
}

}  // namespace balance
