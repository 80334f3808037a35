#include "balance/dynamics/observer.hpp"

#include "balance/base/number.hpp"
#include "balance/dynamics/friction.hpp"
#include "balance/kinematics/joint_coordinates.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace balance {

using std::atan2;

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
    if (tree_.sources[c].column >= 0 && !tree_.joint_floats[coordinate.joint]) {
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
  for (Eigen::Index a = 0; a < seen_.effort.size(); ++a)
    seen_.power[a] = seen_.effort[a] * seen_.velocity[mechanism_.actuators[static_cast<std::size_t>(a)]];
  read_forces();
  if (mechanism_.tool) read_tool(now);
  if (detail == Detail::everything) {
    seen_.com_velocity = to_3d(com_velocity(tree_, *state_));
    read_energies();
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
  const T *y = now.y, *dy = now.dy, *ddy = now.ddy;
  for (const TreeCoordinate& own : own_) {
    seen_.position[own.coordinate] = own.source.ratio * y[own.source.column] + own.source.offset;
    seen_.velocity[own.coordinate] = own.source.ratio * dy[own.source.column];
    seen_.acceleration[own.coordinate] = own.source.ratio * ddy[own.source.column];
  }
  if (!cut_.empty()) read_cut_coordinates(now);
}

template <class S>
void Observer<S>::read_cut_coordinates(const Instant<S>& now) {
  const T *y = now.y, *dy = now.dy, *ddy = now.ddy;
  for (CutCoordinate& cut : cut_) {
    if (!cut.linear) continue;
    if (first_) {  // whole turns are counted from the start
      constexpr double turn = 2 * std::numbers::pi;
      cut.quantity.constant -= turn * std::round(value_of(cut.quantity.value(y)) / turn);
    }
    T position = cut.quantity.constant, velocity = 0, acceleration = 0;
    for (const auto& [column, coefficient] : cut.quantity.terms) {
      position += coefficient * y[column];
      velocity += coefficient * dy[column];
      acceleration += coefficient * ddy[column];
    }
    seen_.position[cut.coordinate] = position;
    seen_.velocity[cut.coordinate] = velocity;
    seen_.acceleration[cut.coordinate] = acceleration;
  }
  if (!cut_joints_.empty()) origin_velocities(tree_, dy, *state_);
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
        const T bend = (seen_.acceleration[cut.coordinate] - reading.acceleration[coordinate.index]) / 12;
        const double expected = value_of(position + step * (mean + step * bend));
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
void Observer<S>::read_forces() {
  const State<S>& state = *state_;
  typename S::Vector moment = S::Vector::Zero();
  for (std::size_t n = 1; n < tree_.nodes.size(); ++n) {
    const auto& inertia = tree_.nodes[n].inertia;
    if (!tree_.nodes[n].massless) moment += state[n].R_WN * inertia.moment + inertia.mass * state[n].p_WN;
  }
  seen_.com = to_3d(typename S::Vector(moment / tree_.mass));
  // the ground's wrench carries the weight and lacks what the surroundings supply
  const typename S::Vector weight = tree_.mass * gravity_;
  const typename S::Angular weight_moment = cross(moment, gravity_);
  const typename S::Vector shaking = wrenches_[0].force + weight + external_total_.force;
  const typename S::Vector ground_force = weight + external_loads_.force - shaking;
  const typename S::Angular about_origin = wrenches_[0].moment + weight_moment + external_total_.moment;
  seen_.shaking_force = to_3d(shaking);
  seen_.shaking_moment = angular_to_3d(typename S::Angular(about_origin - cross(about_, shaking)));
  seen_.com_acceleration = seen_.shaking_force / tree_.mass;
  seen_.ground_force = to_3d(ground_force);
  seen_.ground_moment = angular_to_3d(
      typename S::Angular(weight_moment + external_loads_.moment - about_origin - cross(about_, ground_force)));
}

template <class S>
void Observer<S>::read_tool(const Instant<S>& now) {
  seen_.tool_position = to_3d(position(*state_, tool_));
  seen_.tool_rotation = to_matrix(orientation(*state_, tool_));
  if constexpr (is_planar<S>) seen_.tool_angle = tool_angle_.value(now.y);
}

template <class S>
void Observer<S>::read_energies() {
  const State<S>& state = *state_;
  T kinetic = 0, potential = external_.energy(state);
  for (std::size_t n = 1; n < tree_.nodes.size(); ++n) {
    const auto& inertia = tree_.nodes[n].inertia;
    const NodeState<S>& s = state[n];
    if (tree_.nodes[n].massless) continue;
    kinetic += 0.5 * inertia.mass * s.velocity.squaredNorm() +
               dot(s.velocity, typename S::Vector(cross(s.angular_velocity, inertia.moment))) +
               0.5 * dot(s.angular_velocity, typename S::Angular(inertia.second * s.angular_velocity));
  }
  potential -= tree_.mass * to_3d(gravity_).dot(seen_.com);
  seen_.kinetic_energy = kinetic;
  seen_.potential_energy = potential;
}

template class Observer<PlanarOf<Number>>;
template class Observer<SpatialOf<Number>>;

}  // namespace balance
