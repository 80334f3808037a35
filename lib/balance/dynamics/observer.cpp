#include "balance/dynamics/observer.hpp"

#include "balance/base/elementary.hpp"
#include "balance/base/number.hpp"
#include "balance/dynamics/friction.hpp"
#include "balance/dynamics/readings.hpp"
#include "balance/kinematics/joint_coordinates.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace balance {

using elementary::atan2;

template <class S>
Observer<S>::Observer(const MechanismOf<T>& mechanism, const Tree<S>& tree, int freedoms,
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
  for (auto* values : {&seen_.position, &seen_.velocity, &seen_.acceleration})
    values->setZero(static_cast<Eigen::Index>(coordinates));
  for (auto* values : {&seen_.effort, &seen_.power})
    values->setZero(static_cast<Eigen::Index>(mechanism.actuators.size()));
  seen_.constraint_force.setZero(static_cast<Eigen::Index>(mechanism.constraints.size()));
  seen_.joint_force.assign(joints, Vector3::Zero());
  seen_.joint_moment.assign(joints, Vector3::Zero());
  if (mechanism.tool) {
    Drive<S> drive;
    attach_tool(mechanism, tree, drive);
    tool_ = drive.tool;
    if constexpr (is_planar<S>) tool_angle_ = balance::tool_angle(tree, tool_);
  }
  sort_coordinates();
}

template <class S>
void Observer<S>::sort_coordinates() {
  std::vector<bool> listed(mechanism_.joints.size(), false);
  for (std::size_t c = 0; c < mechanism_.coordinates.size(); ++c) {
    const Coordinate& coordinate = mechanism_.coordinates[c];
    if (tree_.sources[c].depends() && !tree_.floats[c]) {
      own_.push_back({static_cast<int>(c), tree_.sources[c]});
      continue;
    }
    CutCoordinate cut{static_cast<int>(c), false, {}};
    if constexpr (is_planar<S>) {
      if (coordinate.kind == CoordinateKind::angle) {  // the difference of two bodies' angles
        const JointOf<T>& joint = mechanism_.joints[coordinate.joint];
        const LinearQuantityOf<T> second = balance::tool_angle(tree_, tree_.bodies[joint.second]);
        const LinearQuantityOf<T> first = balance::tool_angle(tree_, tree_.bodies[joint.first]);
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
    cut_.push_back(cut);
  }
}

template <class S>
bool Observer<S>::observe(const Instant<S>& now, const Equations<S>& equations, double duration, Detail detail) {
  set_state(now, detail);
  const bool held = balance_efforts(now, equations, duration);
  read_coordinates(now);
  read_rest(now, detail, actuation_.multipliers());
  return held;
}

template <class S>
bool Observer<S>::find_efforts(const Instant<S>& now, const Equations<S>& equations, double duration) {
  set_state(now, Detail::forces);
  return balance_efforts(now, equations, duration);
}

template <class S>
bool Observer<S>::balance_efforts(const Instant<S>& now, const Equations<S>& equations, double duration) {
  balance_forces(now);
  external_.add_joint_springs(now.y, tau_.data());
  if (!mechanism_.friction.empty()) add_friction(mechanism_, tree_, now.dy, duration, tau_.data());
  const bool held = actuation_.solve(equations, tau_.data());
  std::copy(actuation_.efforts().begin(), actuation_.efforts().end(), seen_.effort.data());
  return held;
}

template <class S>
void Observer<S>::observe_under(const Instant<S>& now, const T* efforts, const std::vector<T>& multipliers) {
  set_state(now, Detail::everything);
  balance_forces(now);
  read_coordinates(now);
  std::copy_n(efforts, seen_.effort.size(), seen_.effort.data());
  read_rest(now, Detail::everything, multipliers);
}

template <class S>
void Observer<S>::follow(const Instant<S>& now) {
  set_state(now, Detail::forces);
  read_coordinates(now);
  first_ = false;
  time_ = now.time;
}

template <class S>
void Observer<S>::read_rest(const Instant<S>& now, Detail detail, const std::vector<T>& multipliers) {
  seen_.time = now.time;
  read_power(seen_);
  read_forces<S>(tree_, *state_, {wrenches_[0], external_total_, external_loads_, gravity_, about_}, seen_);
  if (mechanism_.tool) read_tool(now);
  if (detail == Detail::everything) {
    seen_.com_velocity = to_3d(com_velocity(tree_, *state_));
    read_energies(tree_, *state_, gravity_, external_.energy(*state_, now.y), seen_);
    read_reactions(now, multipliers);
    seen_.add_derived(to_3d(about_));
  }
  first_ = false;
  time_ = now.time;
}

/// What the tree's joints and the ground would have to do without closures.
template <class S>
void Observer<S>::balance_forces(const Instant<S>& now) {
  for (auto& wrench : wrenches_) wrench = {};
  external_total_ = external_loads_ = {};
  if (!external_.none()) external_.subtract(*state_, now.time, wrenches_, external_total_, external_loads_);
  inverse_dynamics(tree_, *state_, wrenches_, tau_.data());
}

/// Poses, velocities and accelerations of all nodes, the ground accelerated by −g.
template <class S>
void Observer<S>::set_state(const Instant<S>& now, Detail detail) {
  state_ = &now.state;
  State<S>& state = *state_;
  if (!now.direct) {
    if (detail == Detail::everything) origin_velocities(tree_, now.dy, state);
    accelerations<S>(tree_, now.dy, now.ddy, -gravity_, state);
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
    if (detail == Detail::everything) set_velocity(node, dy, parent, s);
    set_acceleration(node, dy, ddy, parent, s);
    state[n] = s;
  }
}

template <class S>
void Observer<S>::read_coordinates(const Instant<S>& now) {
  if (first_) count_turns(now.y);
  read_linear(now.y, now.dy, now.ddy, seen_);
  if (!cut_joints_.empty()) read_cut_joints(now);
}

/// Whole turns are counted from the start.
template <class S>
void Observer<S>::count_turns(const T* y) {
  constexpr double turn = 2 * std::numbers::pi;
  for (CutCoordinate& cut : cut_)
    if (cut.linear) cut.quantity.constant -= turn * std::round(value_of(cut.quantity.value(y)) / turn);
}

template <class S>
void Observer<S>::read_linear(const T* y, const T* dy, const T* ddy, SampleOf<T>& seen) const {
  for (const TreeCoordinate& own : own_) {
    seen.position[own.coordinate] = own.source.value(y);
    seen.velocity[own.coordinate] = own.source.rate(dy);
    seen.acceleration[own.coordinate] = own.source.rate(ddy);
  }
  for (const CutCoordinate& cut : cut_) {
    if (!cut.linear) continue;
    seen.position[cut.coordinate] = cut.quantity.value(y);
    seen.velocity[cut.coordinate] = cut.quantity.rate(dy);
    seen.acceleration[cut.coordinate] = cut.quantity.rate(ddy);
  }
}

template <class S>
void Observer<S>::complete(const T* y, const T* dy, const T* ddy, SampleOf<T>& seen) const {
  read_linear(y, dy, ddy, seen);
  read_power(seen);
  if constexpr (is_planar<S>)
    if (mechanism_.tool) seen.tool_angle = tool_angle_.value(y);
  seen.add_derived(to_3d(about_));
}

template <class S>
void Observer<S>::read_power(SampleOf<T>& seen) const {
  for (Eigen::Index a = 0; a < seen.effort.size(); ++a)
    seen.power[a] = seen.effort[a] * seen.velocity[mechanism_.actuators[static_cast<std::size_t>(a)]];
}

template <class S>
void Observer<S>::read_cut_joints(const Instant<S>& now) {
  origin_velocities(tree_, now.dy, *state_);
  for (const int j : cut_joints_) {
    const JointOf<T>& joint = mechanism_.joints[j];
    const JointReading<T> reading = read_joint(joint, relative_motion(tree_, *state_, joint));
    for (const CutCoordinate& cut : cut_) {
      const Coordinate& coordinate = mechanism_.coordinates[cut.coordinate];
      if (cut.linear || coordinate.joint != j) continue;
      T& position = seen_.position[cut.coordinate];
      const T value = reading.position[coordinate.index];
      if (coordinate.kind == CoordinateKind::angle && !first_) {
        // how far it has turned since the last look, by the quadrature that rates at both ends allow
        const T step = now.time - time_;
        const T mean = (seen_.velocity[cut.coordinate] + reading.velocity[coordinate.index]) / 2;
        const T curvature = (seen_.acceleration[cut.coordinate] - reading.acceleration[coordinate.index]) / 12;
        const double expected = value_of(position + step * (mean + step * curvature));
        position = unwrapped(value, std::isfinite(expected) ? expected : value_of(position));
      } else {
        position = value;
      }
      seen_.velocity[cut.coordinate] = reading.velocity[coordinate.index];
      seen_.acceleration[cut.coordinate] = reading.acceleration[coordinate.index];
    }
  }
}

template <class S>
void Observer<S>::read_tool(const Instant<S>& now) {
  seen_.tool_position = to_3d(position(*state_, tool_));
  seen_.tool_rotation = to_matrix(orientation(*state_, tool_));
  if constexpr (is_planar<S>) seen_.tool_angle = tool_angle_.value(now.y);
}

template <class S>
void Observer<S>::read_reactions(const Instant<S>& now, const std::vector<T>& multipliers) {
  State<S>& state = *state_;
  if (!tree_.closures.empty()) {
    for (auto& wrench : wrenches_) wrench = {};
    Wrench<S> total, loads;
    if (!external_.none()) external_.subtract(state, now.time, wrenches_, total, loads);
    add_closure_wrenches(tree_, state, multipliers, wrenches_, seen_);
    inverse_dynamics(tree_, state, wrenches_, tau_.data());
  }
  read_transmitted(mechanism_, tree_, state, wrenches_, seen_);
}

template class Observer<PlanarOf<Number>>;
template class Observer<SpatialOf<Number>>;

}  // namespace balance
