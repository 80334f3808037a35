#include "balance/motion/simulation/end_configurations.hpp"

#include "balance/mechanics/dynamics/tree_motion_source.hpp"
#include "balance/mechanics/kinematics/joint_coordinates.hpp"
#include "balance/mechanics/kinematics/space.hpp"
#include "balance/mechanics/trajectory/drive_quantities.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/motion/time_optimal/resolve_trajectory.hpp"

#include <utility>
#include <variant>
#include <vector>

namespace balance::simulation {

namespace {

template <class S>
std::vector<CoordinateValue> find_start_coordinates(const Mechanism& mechanism, const Trajectory& trajectory) {
  const kinematics::Tree<S> tree = kinematics::compile_tree<S>(mechanism, prescribed_coordinates(trajectory));
  const kinematics::PoseEquations<S> start_equations = make_pose_equations(mechanism, tree, trajectory.from);
  kinematics::ConstraintSystem<S> system(tree, start_equations.drive);
  const kinematics::AssemblySolution start = solve_pose(mechanism, tree, system, start_equations.target);
  std::vector<CoordinateValue> values;
  if (!start.found) return values;
  const std::vector<double> coordinates = compute_coordinates(mechanism, tree, start.y);
  for (std::size_t c = 0; c < coordinates.size(); ++c) values.push_back({static_cast<int>(c), coordinates[c]});
  return values;
}

}  // namespace

std::vector<CoordinateValue> start_coordinates(const Mechanism& mechanism, const Trajectory& trajectory) {
  return kinematics::dispatch_space(mechanism.space,
                                    [&]<class S>(S) { return find_start_coordinates<S>(mechanism, trajectory); });
}

std::vector<CoordinateValue> start_coordinates(const Study& study) {
  if (study.trajectories.empty()) return {};
  return start_coordinates(study.mechanism, study.trajectories.front());
}

Mechanism assembled_at(Mechanism mechanism, const std::vector<CoordinateValue>& coordinates) {
  if (!coordinates.empty()) mechanism.assembly = coordinates;
  return mechanism;
}

namespace {

/// Configuration at the start of a run, even if the run fails later.
template <class S>
kinematics::ConfigurationResult find_first_configuration(const Mechanism& mechanism, const Trajectory& trajectory) {
  const kinematics::CompiledMotion<S> motion(mechanism, trajectory);
  dynamics::TreeMotionSource<S> source(mechanism, motion, trajectory.about, dynamics::Detail::kinematics);
  if (!source.begin()) return {source.outcome(), {}};
  kinematics::ConfigurationResult result;
  result.outcome.status = MotionStatus::done;
  const std::vector<double> q = compute_coordinates(
      mechanism, source.tree(), Eigen::Map<const VectorX>(source.stepper().y(), source.tree().columns));
  for (std::size_t c = 0; c < q.size(); ++c) result.coordinates.push_back({static_cast<int>(c), q[c]});
  return result;
}

}  // namespace

kinematics::ConfigurationResult find_start_configuration(const Mechanism& mechanism, Trajectory trajectory) {
  trajectory.adaptations.clear();  // counterweights do not change the configuration
  // a table contains its start; if rates are constrained, `from` may leave the configuration to `assembly`
  if (std::holds_alternative<trajectory::TablePath>(trajectory.path) || has_velocity_constraints(mechanism)) {
    const time_optimal::ResolvedTrajectory resolved = time_optimal::resolve_trajectory(mechanism, trajectory);
    if (resolved.outcome.status != MotionStatus::done) return {resolved.outcome, {}};
    return kinematics::dispatch_space(
        mechanism.space, [&]<class S>(S) { return find_first_configuration<S>(mechanism, resolved.trajectory); });
  }
  return kinematics::solve_configuration(mechanism, trajectory.from);
}

kinematics::ConfigurationResult find_end_configuration(const Mechanism& mechanism, Trajectory trajectory) {
  trajectory.samples = 2;
  trajectory.adaptations.clear();
  RunResult run = simulate(mechanism, trajectory);
  kinematics::ConfigurationResult result{std::move(run.outcome), {}};
  if (result.outcome.status != MotionStatus::done) return result;
  for (Eigen::Index c = 0; c < run.joint_position.cols(); ++c)
    result.coordinates.push_back({static_cast<int>(c), run.joint_position(run.joint_position.rows() - 1, c)});
  return result;
}

}  // namespace balance::simulation
