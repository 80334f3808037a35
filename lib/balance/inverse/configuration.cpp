#include "balance/inverse/configuration.hpp"

#include "balance/kinematics/joint_coordinates.hpp"
#include "balance/motion/missing_start.hpp"

#include <string>

namespace balance {

namespace {

/// Where a pose says too little, or what determines nothing there.
MotionOutcome check_pose_determinacy(int open, int stated, int freedoms) {
  MotionOutcome outcome;
  outcome.status = MotionStatus::done;
  if (open == 0) return outcome;
  if (stated < freedoms) {
    outcome.status = MotionStatus::mismatch;
    outcome.reason = "the pose says too little: it states " + std::to_string(stated) + " of the " +
                     std::to_string(freedoms) + " numbers that determine the mechanism's configuration";
  } else {
    outcome.status = MotionStatus::drive_singularity;
    outcome.reason = "the pose does not determine the configuration: what it states leaves " + std::to_string(open) +
                     " of " + std::to_string(freedoms) + " degrees of freedom open there";
  }
  return outcome;
}

template <class S>
ConfigurationResult solve_configuration_in(const Mechanism& mechanism, const PoseTarget& pose) {
  std::vector<CoordinateId> needed;
  for (const CoordinateValue& value : pose.joints) needed.push_back(value.coordinate);
  const Tree<S> tree = compile_tree<S>(mechanism, needed);
  const PoseEquations<S> stated = make_pose_equations(mechanism, tree, pose);
  ConstraintSystem<S> system(tree, stated.drive);
  const AssemblySolution solution = solve_pose(mechanism, tree, system, stated.target);
  ConfigurationResult found;
  if (!solution.found) {
    found.outcome = explain_assembly_failure(mechanism, tree, solution, pose);
    return found;
  }
  VectorX residual;
  MatrixX jacobian;
  system.evaluate(solution.y, stated.target, residual, jacobian);
  const int freedoms = tree.columns - find_generic_position_rank(tree, solution.y);
  const int open = jacobian.rows() == 0 ? tree.columns : tree.columns - decompose_rank(jacobian).rank;
  found.outcome = check_pose_determinacy(open, stated.drive.row_count(), freedoms);
  const std::vector<double> coordinates = compute_coordinates(mechanism, tree, solution.y);
  for (std::size_t c = 0; c < coordinates.size(); ++c)
    found.coordinates.push_back({static_cast<int>(c), coordinates[c]});
  // the stated ones with their whole turns
  for (const CoordinateValue& value : pose.joints)
    found.coordinates[static_cast<std::size_t>(value.coordinate)].value = value.value;
  return found;
}

}  // namespace

ConfigurationResult solve_configuration(const Mechanism& mechanism, const PoseTarget& pose) {
  return dispatch_space(mechanism.space, [&]<class S>(S) { return solve_configuration_in<S>(mechanism, pose); });
}

}  // namespace balance
