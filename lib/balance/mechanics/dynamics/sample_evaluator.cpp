#include "balance/mechanics/dynamics/sample_evaluator.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/numerics/engine_scalar.hpp"
#include "balance/mechanics/dynamics/external_forces.hpp"
#include "balance/mechanics/dynamics/sample_quantities.hpp"
#include "balance/mechanics/kinematics/joint_coordinates.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace balance {

using elementary::atan2;

template <class S>
SampleEvaluator<S>::SampleEvaluator(const MechanismOf<T>& mechanism, const Tree<S>& tree, int freedoms,
                                    const typename S::Vector& about)
    : mechanism_(mechanism),
      tree_(tree),
      gravity_(to_vector<S>(mechanism.gravity)),
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
  sample_.constraint_force.setZero(static_cast<Eigen::Index>(mechanism.constraints.size()));
  sample_.joint_force.assign(joints, Vector3::Zero());
  sample_.joint_moment.assign(joints, Vector3::Zero());
  if (mechanism.tool) {
    Drive<S> drive;
    set_tool_frame(mechanism, tree, drive);
    tool_ = drive.tool;
    if constexpr (is_planar<S>) tool_angle_ = balance::make_tool_angle_expression(tree, tool_);
  }
  classify_coordinates();
}

template <class S>
void SampleEvaluator<S>::classify_coordinates() {
  std::vector<bool> listed(mechanism_.joints.size(), false);
  for (std::size_t c = 0; c < mechanism_.coordinates.size(); ++c) {
    const Coordinate& coordinate = mechanism_.coordinates[c];
    if (tree_.coordinate_expressions[c].has_terms() && !tree_.is_floating[c]) {
      tree_coordinates_.push_back({static_cast<int>(c), tree_.coordinate_expressions[c]});
      continue;
    }
    CutCoordinate cut{static_cast<int>(c), false, {}};
    if constexpr (is_planar<S>) {
      if (coordinate.kind == CoordinateKind::angle) {  // the difference of two bodies' angles
        const JointOf<T>& joint = mechanism_.joints[coordinate.joint];
        const LinearQuantityOf<T> second = balance::make_tool_angle_expression(tree_, tree_.bodies[joint.second]);
        const LinearQuantityOf<T> first = balance::make_tool_angle_expression(tree_, tree_.bodies[joint.first]);
        cut.linear = true;
        cut.quantity = second;
        cut.quantity.constant -= first.constant + atan2(joint.rotation(1, 0), joint.rotation(0, 0));
        for (const auto& [column, coefficient] : first.terms) cut.quantity.terms.emplace_back(column, -coefficient);
      }
    }
    if (!cut.linear && !listed[coordinate.joint]) {
      listed[coordinate.joint] = true;
      cut_joints_.push_back(coordinate.joint);
    }
    cut_coordinates_.push_back(cut);
  }
}

template <class S>
bool SampleEvaluator<S>::evaluate(const TreeMotion<S>& now, const KinematicEquations<S>& equations, double duration,
                                  Detail detail) {
  set_state(now, detail);
  const bool held = balance_efforts(now, equations, duration);
  read_coordinates(now);
  compute_derived_quantities(now, detail, actuation_.multipliers());
  return held;
}

template <class S>
bool SampleEvaluator<S>::solve_efforts(const TreeMotion<S>& now, const KinematicEquations<S>& equations,
                                       double duration) {
  set_state(now, Detail::forces);
  return balance_efforts(now, equations, duration);
}

template <class S>
bool SampleEvaluator<S>::balance_efforts(const TreeMotion<S>& now, const KinematicEquations<S>& equations,
                                         double duration) {
  balance_forces(now);
  external_.add_joint_springs(now.y, tau_.data());
  if (!mechanism_.friction.empty()) add_friction_forces(mechanism_, tree_, now.dy, duration, tau_.data());
  const bool held = actuation_.solve(equations, tau_.data());
  std::copy(actuation_.efforts().begin(), actuation_.efforts().end(), sample_.effort.data());
  return held;
}

template <class S>
void SampleEvaluator<S>::evaluate_under_efforts(const TreeMotion<S>& now, const T* efforts,
                                                const std::vector<T>& multipliers) {
  set_state(now, Detail::all);
  balance_forces(now);
  read_coordinates(now);
  std::copy_n(efforts, sample_.effort.size(), sample_.effort.data());
  compute_derived_quantities(now, Detail::all, multipliers);
}

template <class S>
void SampleEvaluator<S>::update_coordinates(const TreeMotion<S>& now) {
  set_state(now, Detail::forces);
  read_coordinates(now);
  first_ = false;
  time_ = now.time;
}

template <class S>
void SampleEvaluator<S>::compute_derived_quantities(const TreeMotion<S>& now, Detail detail,
                                                    const std::vector<T>& multipliers) {
  sample_.time = now.time;
  read_power(sample_);
  compute_total_forces<S>(tree_, *state_, {wrenches_[0], external_total_, external_loads_, gravity_, about_}, sample_);
  if (mechanism_.tool) read_tool(now);
  if (detail == Detail::all) {
    sample_.com_velocity = to_3d(com_velocity(tree_, *state_));
    compute_energies(tree_, *state_, gravity_, external_.energy(*state_, now.y), sample_);
    read_reactions(now, multipliers);
    sample_.add_derived(to_3d(about_));
  }
  first_ = false;
  time_ = now.time;
}

/// What the tree's joints and the ground would have to do without closures.
template <class S>
void SampleEvaluator<S>::balance_forces(const TreeMotion<S>& now) {
  for (auto& wrench : wrenches_) wrench = {};
  external_total_ = external_loads_ = {};
  if (!external_.is_empty()) external_.subtract(*state_, now.time, wrenches_, external_total_, external_loads_);
  inverse_dynamics(tree_, *state_, wrenches_, tau_.data());
}

/// Poses, velocities and accelerations of all nodes, the ground accelerated by −g.
template <class S>
void SampleEvaluator<S>::set_state(const TreeMotion<S>& now, Detail detail) {
  state_ = &now.state;
  TreeState<S>& state = *state_;
  if (!now.is_explicit) {
    if (detail == Detail::all) compute_origin_velocities(tree_, now.dy, state);
    compute_accelerations<S>(tree_, now.dy, now.ddy, -gravity_, state);
    return;
  }
  const T *y = now.y, *dy = now.dy, *ddy = now.ddy;
  state[0].acceleration = -gravity_;
  for (std::size_t n = 1; n < tree_.nodes.size(); ++n) {
    const Node<S>& node = tree_.nodes[n];
    const NodeState<S>& parent = state[node.parent];
    NodeState<S> s;  // worked on in registers
    set_local_pose(node, y, s);
    set_world_pose(parent, s);
    set_angular_velocity(node, dy, parent, s);
    if (detail == Detail::all) set_velocity(node, dy, parent, s);
    set_acceleration(node, dy, ddy, parent, s);
    state[n] = s;
  }
}

template <class S>
void SampleEvaluator<S>::read_coordinates(const TreeMotion<S>& now) {
  if (first_) initialise_turns(now.y);
  read_linear(now.y, now.dy, now.ddy, sample_);
  if (!cut_joints_.empty()) compute_cut_joints(now);
}

/// Whole turns are counted from the start.
template <class S>
void SampleEvaluator<S>::initialise_turns(const T* y) {
  constexpr double two_pi = 2 * std::numbers::pi;
  for (CutCoordinate& cut : cut_coordinates_)
    if (cut.linear) cut.quantity.constant -= two_pi * std::round(value_of(cut.quantity.value(y)) / two_pi);
}

template <class S>
void SampleEvaluator<S>::read_linear(const T* y, const T* dy, const T* ddy, SampleOf<T>& seen) const {
  for (const TreeCoordinate& own : tree_coordinates_) {
    seen.position[own.coordinate] = own.source.value(y);
    seen.velocity[own.coordinate] = own.source.rate(dy);
    seen.acceleration[own.coordinate] = own.source.rate(ddy);
  }
  for (const CutCoordinate& cut : cut_coordinates_) {
    if (!cut.linear) continue;
    seen.position[cut.coordinate] = cut.quantity.value(y);
    seen.velocity[cut.coordinate] = cut.quantity.rate(dy);
    seen.acceleration[cut.coordinate] = cut.quantity.rate(ddy);
  }
}

template <class S>
void SampleEvaluator<S>::complete_sample(const T* y, const T* dy, const T* ddy, SampleOf<T>& seen) const {
  read_linear(y, dy, ddy, seen);
  read_power(seen);
  if constexpr (is_planar<S>)
    if (mechanism_.tool) seen.tool_angle = tool_angle_.value(y);
  seen.add_derived(to_3d(about_));
}

template <class S>
void SampleEvaluator<S>::read_power(SampleOf<T>& seen) const {
  for (Eigen::Index a = 0; a < seen.effort.size(); ++a)
    seen.power[a] = seen.effort[a] * seen.velocity[mechanism_.actuators[static_cast<std::size_t>(a)]];
}

template <class S>
void SampleEvaluator<S>::compute_cut_joints(const TreeMotion<S>& now) {
  compute_origin_velocities(tree_, now.dy, *state_);
  for (const int j : cut_joints_) {
    const JointOf<T>& joint = mechanism_.joints[j];
    const JointMotion<T> reading = compute_joint_motion(joint, relative_motion(tree_, *state_, joint));
    for (const CutCoordinate& cut : cut_coordinates_) {
      const Coordinate& coordinate = mechanism_.coordinates[cut.coordinate];
      if (cut.linear || coordinate.joint != j) continue;
      T& position = sample_.position[cut.coordinate];
      const T value = reading.position[coordinate.index];
      if (coordinate.kind == CoordinateKind::angle && !first_) {
        // how far it has turned since the last look, by the quadrature that rates at both ends allow
        const T step = now.time - time_;
        const T mean = (sample_.velocity[cut.coordinate] + reading.velocity[coordinate.index]) / 2;
        const T curvature = (sample_.acceleration[cut.coordinate] - reading.acceleration[coordinate.index]) / 12;
        const double expected = value_of(position + step * (mean + step * curvature));
        position = unwrap_angle(value, std::isfinite(expected) ? expected : value_of(position));
      } else {
        position = value;
      }
      sample_.velocity[cut.coordinate] = reading.velocity[coordinate.index];
      sample_.acceleration[cut.coordinate] = reading.acceleration[coordinate.index];
    }
  }
}

template <class S>
void SampleEvaluator<S>::read_tool(const TreeMotion<S>& now) {
  sample_.tool_position = to_3d(position(*state_, tool_));
  sample_.tool_rotation = to_matrix(orientation(*state_, tool_));
  if constexpr (is_planar<S>) sample_.tool_angle = tool_angle_.value(now.y);
}

template <class S>
void SampleEvaluator<S>::read_reactions(const TreeMotion<S>& now, const std::vector<T>& multipliers) {
  TreeState<S>& state = *state_;
  if (!tree_.closures.empty()) {
    for (auto& wrench : wrenches_) wrench = {};
    Wrench<S> total, loads;
    if (!external_.is_empty()) external_.subtract(state, now.time, wrenches_, total, loads);
    add_closure_wrenches(tree_, state, multipliers, wrenches_, sample_);
    inverse_dynamics(tree_, state, wrenches_, tau_.data());
  }
  compute_joint_reactions(mechanism_, tree_, state, wrenches_, sample_);
}

template class SampleEvaluator<PlanarOf<EngineScalar>>;
template class SampleEvaluator<SpatialOf<EngineScalar>>;

}  // namespace balance
