#include "balance/mechanics/dynamics/sample_evaluator.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/numerics/engine_scalar.hpp"
#include "balance/mechanics/dynamics/external_forces.hpp"
#include "balance/mechanics/dynamics/sample_quantities.hpp"
#include "balance/mechanics/kinematics/joint_coordinates.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace balance::dynamics {

using elementary::atan2;

template <class S>
SampleEvaluator<S>::SampleEvaluator(const MechanismOf<T>& mechanism, const kinematics::Tree<S>& tree, int freedoms,
                                    const typename S::Vector& about)
    : mechanism_(mechanism),
      tree_(tree),
      gravity_(kinematics::to_vector<S>(mechanism.gravity)),
      about_(about),
      external_(mechanism, tree),
      actuation_(mechanism, tree, freedoms),
      wrenches_(tree.nodes.size()),
      tau_(tree.columns) {
  const std::size_t coordinates = mechanism.coordinates.size(), joints = mechanism.joints.size();
  for (auto* values : {&sample_.position, &sample_.velocity, &sample_.acceleration})
    values->setZero(static_cast<Eigen::Index>(coordinates));
  for (auto* values : {&sample_.effort, &sample_.power})
    values->setZero(static_cast<Eigen::Index>(mechanism.actuators.size()));
  for (auto* values : {&sample_.constraint_force, &sample_.constraint_power})
    values->setZero(static_cast<Eigen::Index>(mechanism.constraints.size()));
  sample_.joint_force.assign(joints, Vector3::Zero());
  sample_.joint_moment.assign(joints, Vector3::Zero());
  if (mechanism.tool) {
    kinematics::Drive<S> drive;
    set_tool_frame(mechanism, tree, drive);
    tool_ = drive.tool;
    if constexpr (kinematics::is_planar<S>) tool_angle_ = kinematics::make_tool_angle_expression(tree, tool_);
  }
  classify_coordinates();
}

template <class S>
void SampleEvaluator<S>::classify_coordinates() {
  std::vector<bool> is_listed(mechanism_.joints.size(), false);
  for (std::size_t c = 0; c < mechanism_.coordinates.size(); ++c) {
    const Coordinate& coordinate = mechanism_.coordinates[c];
    if (tree_.coordinate_expressions[c].has_terms() && !tree_.is_floating[c]) {
      tree_coordinates_.push_back({static_cast<int>(c), tree_.coordinate_expressions[c]});
      continue;
    }
    CutCoordinate cut{static_cast<int>(c), false, {}};
    if constexpr (kinematics::is_planar<S>) {
      if (coordinate.kind == CoordinateKind::angle) {  // the difference of two bodies' angles
        const model::JointOf<T>& joint = mechanism_.joints[coordinate.joint];
        const kinematics::LinearQuantityOf<T> second =
            kinematics::make_tool_angle_expression(tree_, tree_.bodies[joint.second]);
        const kinematics::LinearQuantityOf<T> first =
            kinematics::make_tool_angle_expression(tree_, tree_.bodies[joint.first]);
        cut.linear = true;
        cut.quantity = second;
        cut.quantity.constant -= first.constant + atan2(joint.rotation(1, 0), joint.rotation(0, 0));
        for (const auto& [column, coefficient] : first.terms) cut.quantity.terms.emplace_back(column, -coefficient);
      }
    }
    if (!cut.linear && !is_listed[coordinate.joint]) {
      is_listed[coordinate.joint] = true;
      cut_joints_.push_back(coordinate.joint);
    }
    cut_coordinates_.push_back(cut);
  }
}

template <class S>
bool SampleEvaluator<S>::evaluate(const TreeMotion<S>& motion, const kinematics::KinematicEquations<S>& equations,
                                  double duration, Detail detail) {
  if (detail == Detail::kinematics) {
    update_coordinates(motion);
    if (mechanism_.tool) read_tool(motion);
    return true;
  }
  set_state(motion, detail);
  const bool is_held = balance_efforts(motion, equations, duration);
  read_coordinates(motion);
  compute_derived_quantities(motion, detail, actuation_.multipliers());
  return is_held;
}

template <class S>
bool SampleEvaluator<S>::solve_efforts(const TreeMotion<S>& motion, const kinematics::KinematicEquations<S>& equations,
                                       double duration) {
  set_state(motion, Detail::forces);
  return balance_efforts(motion, equations, duration);
}

template <class S>
bool SampleEvaluator<S>::balance_efforts(const TreeMotion<S>& motion,
                                         const kinematics::KinematicEquations<S>& equations, double duration) {
  balance_forces(motion);
  external_.add_joint_springs(motion.y, tau_.data());
  if (!mechanism_.friction.empty()) add_friction_forces(mechanism_, tree_, motion.dy, duration, tau_.data());
  const bool is_held = actuation_.solve(equations, tau_.data());
  std::copy(actuation_.efforts().begin(), actuation_.efforts().end(), sample_.effort.data());
  return is_held;
}

template <class S>
void SampleEvaluator<S>::evaluate_under_efforts(const TreeMotion<S>& motion, const T* efforts,
                                                const std::vector<T>& multipliers) {
  set_state(motion, Detail::all);
  balance_forces(motion);
  read_coordinates(motion);
  std::copy_n(efforts, sample_.effort.size(), sample_.effort.data());
  compute_derived_quantities(motion, Detail::all, multipliers);
}

template <class S>
void SampleEvaluator<S>::update_coordinates(const TreeMotion<S>& motion) {
  set_state(motion, Detail::forces);
  read_coordinates(motion);
  is_first_ = false;
  last_time_ = motion.time;
}

template <class S>
void SampleEvaluator<S>::compute_derived_quantities(const TreeMotion<S>& motion, Detail detail,
                                                    const std::vector<T>& multipliers) {
  sample_.time = motion.time;
  read_power(sample_);
  compute_total_forces<S>(tree_, *state_, {wrenches_[0], external_total_, external_loads_, gravity_, about_}, sample_);
  if (mechanism_.tool) read_tool(motion);
  if (detail == Detail::all) {
    sample_.com_velocity = kinematics::to_3d(com_velocity(tree_, *state_));
    compute_energies(tree_, *state_, gravity_, external_.energy(*state_, motion.y), sample_);
    read_reactions(motion, multipliers);
    Eigen::Index constraint = 0;
    for (const kinematics::Closure<S>& closure : tree_.closures) {
      if (closure.terms.empty()) continue;
      const double speed = model::evaluate_at_time(closure.value, value_of(motion.time)).value;
      sample_.constraint_power[constraint] = speed * sample_.constraint_force[constraint];
      ++constraint;
    }
    sample_.add_derived(kinematics::to_3d(about_));
  }
  is_first_ = false;
  last_time_ = motion.time;
}

/// Wrenches that the tree's joints and the ground would have to exert without closures.
template <class S>
void SampleEvaluator<S>::balance_forces(const TreeMotion<S>& motion) {
  for (auto& wrench : wrenches_) wrench = {};
  external_total_ = external_loads_ = {};
  if (external_.has_dampers()) compute_origin_velocities(tree_, motion.dy, *state_);
  if (!external_.is_empty())
    external_.subtract(*state_, motion.y, motion.time, wrenches_, external_total_, external_loads_);
  inverse_dynamics(tree_, *state_, wrenches_, tau_.data());
}

/// Updates velocities and accelerations of all nodes, and the poses of an explicit motion, with the ground accelerated
/// by −g.
template <class S>
void SampleEvaluator<S>::set_state(const TreeMotion<S>& motion, Detail detail) {
  state_ = &motion.state;
  kinematics::TreeState<S>& state = *state_;
  if (!motion.is_explicit) {
    if (detail == Detail::all) compute_origin_velocities(tree_, motion.dy, state);
    kinematics::compute_accelerations<S>(tree_, motion.dy, motion.ddy, -gravity_, state);
    return;
  }
  const T *y = motion.y, *dy = motion.dy, *ddy = motion.ddy;
  state[0].acceleration = -gravity_;
  for (std::size_t n = 1; n < tree_.nodes.size(); ++n) {
    const kinematics::Node<S>& node = tree_.nodes[n];
    const kinematics::NodeState<S>& parent = state[node.parent];
    kinematics::NodeState<S> s;  // kept in registers
    set_local_pose(node, y, s);
    set_world_pose(parent, s);
    set_angular_velocity(node, dy, parent, s);
    if (detail == Detail::all) set_velocity(node, dy, parent, s);
    set_acceleration(node, dy, ddy, parent, s);
    state[n] = s;
  }
}

template <class S>
void SampleEvaluator<S>::read_coordinates(const TreeMotion<S>& motion) {
  if (is_first_) initialise_turns(motion.y);
  read_linear(motion.y, motion.dy, motion.ddy, sample_);
  if (!cut_joints_.empty()) compute_cut_joints(motion);
}

/// Starts the count of full turns.
template <class S>
void SampleEvaluator<S>::initialise_turns(const T* y) {
  constexpr double two_pi = 2 * std::numbers::pi;
  for (CutCoordinate& cut : cut_coordinates_)
    if (cut.linear) cut.quantity.constant -= two_pi * std::round(value_of(cut.quantity.value(y)) / two_pi);
}

template <class S>
void SampleEvaluator<S>::continue_turns(const VectorX& near) {
  constexpr double two_pi = 2 * std::numbers::pi;
  for (CutCoordinate& cut : cut_coordinates_) {
    if (mechanism_.coordinates[cut.coordinate].kind != CoordinateKind::angle) continue;
    T& position = sample_.position[cut.coordinate];
    const double turns = two_pi * std::round((near[cut.coordinate] - value_of(position)) / two_pi);
    position += turns;
    if (cut.linear) cut.quantity.constant += turns;
  }
}

template <class S>
void SampleEvaluator<S>::read_linear(const T* y, const T* dy, const T* ddy, trajectory::SampleOf<T>& sample) const {
  for (const TreeCoordinate& tree_coordinate : tree_coordinates_) {
    sample.position[tree_coordinate.coordinate] = tree_coordinate.source.value(y);
    sample.velocity[tree_coordinate.coordinate] = tree_coordinate.source.rate(dy);
    sample.acceleration[tree_coordinate.coordinate] = tree_coordinate.source.rate(ddy);
  }
  for (const CutCoordinate& cut : cut_coordinates_) {
    if (!cut.linear) continue;
    sample.position[cut.coordinate] = cut.quantity.value(y);
    sample.velocity[cut.coordinate] = cut.quantity.rate(dy);
    sample.acceleration[cut.coordinate] = cut.quantity.rate(ddy);
  }
}

template <class S>
void SampleEvaluator<S>::complete_sample(const T* y, const T* dy, const T* ddy, trajectory::SampleOf<T>& sample) const {
  read_linear(y, dy, ddy, sample);
  read_power(sample);
  if constexpr (kinematics::is_planar<S>)
    if (mechanism_.tool) sample.tool_angle = tool_angle_.value(y);
  sample.add_derived(kinematics::to_3d(about_));
}

template <class S>
void SampleEvaluator<S>::read_power(trajectory::SampleOf<T>& sample) const {
  for (Eigen::Index a = 0; a < sample.effort.size(); ++a)
    sample.power[a] = sample.effort[a] * sample.velocity[mechanism_.actuators[static_cast<std::size_t>(a)]];
}

template <class S>
void SampleEvaluator<S>::compute_cut_joints(const TreeMotion<S>& motion) {
  compute_origin_velocities(tree_, motion.dy, *state_);
  for (const int j : cut_joints_) {
    const model::JointOf<T>& joint = mechanism_.joints[j];
    const kinematics::JointMotion<T> joint_motion = compute_joint_motion(joint, relative_motion(tree_, *state_, joint));
    for (const CutCoordinate& cut : cut_coordinates_) {
      const Coordinate& coordinate = mechanism_.coordinates[cut.coordinate];
      if (cut.linear || coordinate.joint != j) continue;
      T& position = sample_.position[cut.coordinate];
      const T value = joint_motion.position[coordinate.index];
      if (coordinate.kind == CoordinateKind::angle && !is_first_) {
        // rotation since the last evaluation, by a quadrature with the rates and accelerations at both ends
        const T step = motion.time - last_time_;
        const T mean = (sample_.velocity[cut.coordinate] + joint_motion.velocity[coordinate.index]) / 2;
        const T curvature = (sample_.acceleration[cut.coordinate] - joint_motion.acceleration[coordinate.index]) / 12;
        const double expected = value_of(position + step * (mean + step * curvature));
        position = kinematics::unwrap_angle(value, std::isfinite(expected) ? expected : value_of(position));
      } else {
        position = value;
      }
      sample_.velocity[cut.coordinate] = joint_motion.velocity[coordinate.index];
      sample_.acceleration[cut.coordinate] = joint_motion.acceleration[coordinate.index];
    }
  }
}

template <class S>
void SampleEvaluator<S>::read_tool(const TreeMotion<S>& motion) {
  sample_.tool_position = kinematics::to_3d(position(*state_, tool_));
  sample_.tool_rotation = to_matrix(orientation(*state_, tool_));
  if constexpr (kinematics::is_planar<S>) sample_.tool_angle = tool_angle_.value(motion.y);
}

template <class S>
void SampleEvaluator<S>::read_reactions(const TreeMotion<S>& motion, const std::vector<T>& multipliers) {
  kinematics::TreeState<S>& state = *state_;
  if (!tree_.closures.empty()) {
    for (auto& wrench : wrenches_) wrench = {};
    Wrench<S> total, loads;
    if (!external_.is_empty()) external_.subtract(state, motion.y, motion.time, wrenches_, total, loads);
    add_closure_wrenches(tree_, state, multipliers, wrenches_, sample_);
    inverse_dynamics(tree_, state, wrenches_, tau_.data());
  }
  compute_joint_reactions(mechanism_, tree_, state, wrenches_, sample_);
}

template class SampleEvaluator<kinematics::PlanarOf<EngineScalar>>;
template class SampleEvaluator<kinematics::SpatialOf<EngineScalar>>;

}  // namespace balance::dynamics
