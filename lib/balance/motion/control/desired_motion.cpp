#include "balance/motion/control/desired_motion.hpp"

#include "balance/mechanics/dynamics/sample_evaluator.hpp"
#include "balance/mechanics/kinematics/joint_coordinates.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace balance {

namespace {

template <class S>
class DesiredMotionSampler {
 public:
  DesiredMotionSampler(const Mechanism& mechanism, const Trajectory& trajectory)
      : mechanism_(mechanism),
        trajectory_(trajectory),
        tree_(compile_tree<S>(mechanism, prescribed_coordinates(trajectory))),
        plan_(compile_trajectory(mechanism, tree_, trajectory)) {}

  DesiredMotion run(const std::vector<double>& times) {
    desired_.outcome = plan_.outcome;
    if (plan_.outcome.status != MotionStatus::done) return std::move(desired_);
    desired_.duration = plan_.prescribed_motion->duration();
    allocate(static_cast<Eigen::Index>(times.size()));
    SampleEvaluator<S> evaluator(mechanism_, tree_, plan_.freedoms, to_vector<S>(trajectory_.about));
    MotionStepper<S> stepper(mechanism_, tree_, plan_);
    if (!stepper.begin() || !visit_times(times, stepper, evaluator)) desired_.outcome = stepper.outcome();
    return std::move(desired_);
  }

 private:
  void allocate(Eigen::Index rows) {
    const auto coordinates = static_cast<Eigen::Index>(mechanism_.coordinates.size());
    for (Samples* array : {&desired_.position, &desired_.velocity, &desired_.acceleration})
      array->setZero(rows, coordinates);
    if (!mechanism_.tool) return;
    desired_.tool_position.setZero(rows, 3);
    if (mechanism_.space == SpaceKind::planar)
      desired_.tool_angle.setZero(rows);
    else
      desired_.tool_rotation.resize(static_cast<std::size_t>(rows));
  }

  bool visit_times(const std::vector<double>& times, MotionStepper<S>& stepper, SampleEvaluator<S>& evaluator) {
    const std::vector<double>& jumps = plan_.prescribed_motion->jump_times();
    std::size_t jump = 0;
    for (std::size_t k = 0; k < times.size(); ++k) {
      const double time = std::min(times[k], desired_.duration);
      // Steps end exactly at jumps, so that no prediction extends across one.
      for (; jump < jumps.size() && jumps[jump] < time; ++jump)
        if (jumps[jump] > stepper.time() && !stepper.advance(jumps[jump])) return false;
      if (time > stepper.time() && !stepper.advance(time)) return false;
      evaluator.evaluate_kinematics(stepper);
      record(evaluator.sample(), static_cast<Eigen::Index>(k), times[k] > desired_.duration * (1 + 1e-12));
    }
    return true;
  }

  void record(const Sample& sample, Eigen::Index row, bool is_held) {
    desired_.rows = row + 1;
    desired_.position.row(row) = sample.position;
    if (!is_held) {
      desired_.velocity.row(row) = sample.velocity;
      desired_.acceleration.row(row) = sample.acceleration;
    }
    if (!mechanism_.tool) return;
    for (int i = 0; i < S::dimension; ++i) desired_.tool_position(row, i) = sample.tool_position[i];
    if constexpr (std::is_same_v<S, Planar>)
      desired_.tool_angle[row] = sample.tool_angle;
    else
      desired_.tool_rotation[static_cast<std::size_t>(row)] = sample.tool_rotation;
  }

  const Mechanism& mechanism_;
  const Trajectory& trajectory_;
  Tree<S> tree_;
  CompiledTrajectory<S> plan_;
  DesiredMotion desired_;
};

template <class S>
MotionOutcome find_start_position(const Mechanism& mechanism, const Trajectory& trajectory, VectorX& position) {
  const Tree<S> tree = compile_tree<S>(mechanism, prescribed_coordinates(trajectory));
  const PoseEquations<S> start_equations = make_pose_equations(mechanism, tree, trajectory.from);
  ConstraintSystem<S> system(tree, start_equations.drive);
  const AssemblySolution start = solve_pose(mechanism, tree, system, start_equations.target);
  if (!start.found) return {MotionStatus::unreachable, 0, "the start pose cannot be reached", {}};
  const std::vector<double> coordinates = compute_coordinates(mechanism, tree, start.y);
  position = Eigen::Map<const VectorX>(coordinates.data(), static_cast<Eigen::Index>(coordinates.size()));
  return {MotionStatus::done, 0, "", {}};
}

template <class S>
MotionOutcome displace_tool_in(const Mechanism& mechanism, const Trajectory& trajectory, const Vector3& displacement,
                               double angle, VectorX& position) {
  const Tree<S> tree = compile_tree<S>(mechanism, prescribed_coordinates(trajectory));
  const CompiledTrajectory<S> plan = compile_trajectory(mechanism, tree, trajectory);
  if (plan.outcome.status != MotionStatus::done) return plan.outcome;
  PoseTarget pose;
  pose.tool = Vector3::Zero();
  if constexpr (std::is_same_v<S, Planar>)
    if (plan.freedoms >= 3) pose.angle = 0;
  const PoseEquations<S> equations = make_pose_equations(mechanism, tree, pose);
  ConstraintSystem<S> system(tree, equations.drive);
  VectorX residual;
  MatrixX jacobian;
  system.evaluate(plan.start, equations.target, residual, jacobian);
  const DriveSample from = system.measure(plan.start);
  DriveSample to = from;
  for (int i = 0; i < S::dimension; ++i) to.value[i] += displacement[i];
  if (pose.angle) to.value[S::dimension] += angle;
  const AssemblySolution solution = track_to(system, plan.start, from, to);
  if (!solution.found) return {MotionStatus::unreachable, 0, "the initial error puts the tool out of reach", {}};
  for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c) {
    const LinearQuantity& expression = tree.coordinate_expressions[c];
    if (expression.has_terms()) position[static_cast<Eigen::Index>(c)] = expression.value(solution.y.data());
  }
  return {MotionStatus::done, 0, "", {}};
}

}  // namespace

double find_trajectory_duration(const Trajectory& trajectory) {
  const auto* table = std::get_if<TablePath>(&trajectory.path);
  return table == nullptr || is_mechanism_dependent(trajectory.law.kind) ? trajectory.duration
                                                                         : table->time.back() - table->time.front();
}

DesiredMotion compute_desired_motion(const Mechanism& mechanism, const Trajectory& trajectory,
                                     const std::vector<double>& times) {
  if (times.empty() || times.front() != 0) throw std::invalid_argument("a desired motion begins at time 0");
  return dispatch_space(mechanism.space,
                        [&]<class S>(S) { return DesiredMotionSampler<S>(mechanism, trajectory).run(times); });
}

MotionOutcome solve_start_position(const Mechanism& mechanism, const Trajectory& trajectory, VectorX& position) {
  return dispatch_space(mechanism.space,
                        [&]<class S>(S) { return find_start_position<S>(mechanism, trajectory, position); });
}

MotionOutcome displace_tool(const Mechanism& mechanism, const Trajectory& trajectory, const Vector3& displacement,
                            double angle, VectorX& position) {
  return dispatch_space(mechanism.space, [&]<class S>(S) {
    return displace_tool_in<S>(mechanism, trajectory, displacement, angle, position);
  });
}

}  // namespace balance
