#include "balance/mechanics/dynamics/term_magnitude_recorder.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

namespace {

/// What equations leave uncertain of what they are solved for: their residual goes down to 1e-12, and round-off grows with the inverse of
/// the mobility, or its square.
double solution_round_off_factor(double growth) { return std::max(1e-12, 8 * round_off_factor * growth); }

/// Near a singularity a rate of this part is a rate all the same.
constexpr double max_rest_fraction = 1e-6;

}  // namespace

void TermMagnitudes::raise_to(const TermMagnitudes& other, double factor) {
  for (VectorX TermMagnitudes::*member : term_magnitude_members) {
    VectorX& mine = this->*member;
    const VectorX& its = other.*member;
    if (mine.size() != its.size()) mine.setZero(its.size());
    mine = mine.cwiseMax(factor * its);
  }
}

template <class S>
TermMagnitudeRecorder<S>::TermMagnitudeRecorder(const Mechanism& mechanism, const Tree<S>& tree,
                                                const typename S::Vector& about, const RestScale& rest)
    : mechanism_(mechanism),
      tree_(tree),
      gravity_(mechanism.gravity.norm()),
      about_(about.norm()),
      external_(mechanism, tree),
      nodes_(tree.nodes.size()),
      rest_scale_(rest),
      dy_(static_cast<std::size_t>(tree.columns)),
      ddy_(dy_),
      tau_(dy_),
      external_sizes_(tree.nodes.size()) {
  for (const MassElement<S>& element : tree.mass_elements) {
    NodeMagnitudes& node = nodes_[static_cast<std::size_t>(element.frame.node)];
    const double mass = element.inertia.mass, reach = element.frame.p_N.norm(),
                 first = element.inertia.first_moment.norm();
    double second = 0;
    if constexpr (S::dimension == 2)
      second = std::abs(element.inertia.second_moment);
    else
      second = element.inertia.second_moment.norm();
    node.mass += mass;
    node.first += first + mass * reach;
    node.second += second + 2 * reach * first + mass * reach * reach;
  }
  const auto size = [](const auto& list) { return static_cast<Eigen::Index>(list.size()); };
  for (auto* values : {&now_.position, &now_.velocity, &now_.acceleration})
    values->setZero(size(mechanism.coordinates));
  for (auto* values : {&now_.effort, &now_.power}) values->setZero(size(mechanism.actuators));
  for (auto* values : {&now_.joint_force, &now_.joint_moment}) values->setZero(size(mechanism.joints));
  now_.constraint_force.setZero(size(mechanism.constraints));
  for (auto* value :
       {&now_.com_position, &now_.com_velocity, &now_.com_acceleration, &now_.shaking_force, &now_.shaking_moment,
        &now_.force, &now_.moment, &now_.moment_com, &now_.total_effort, &now_.kinetic_energy, &now_.potential_energy})
    value->setZero(1);
  if (!mechanism.tool) return;
  now_.tool_position.setZero(1);
  now_.tool_angle.setOnes(1);
  const FixedFrame<S>& body = tree.bodies[static_cast<std::size_t>(mechanism.tool->body)];
  tool_ = {body.node, body.R_N, body.p_N + body.R_N * to_vector<S>(mechanism.tool->position)};
}

template <class S>
void TermMagnitudeRecorder<S>::sample(const TreeMotion<S>& now, const Sample& seen,
                                      const std::vector<double>& multipliers, double mobility) {
  const double growth = mobility < 1 ? 1 / std::max(mobility, 1e-12) : 1;
  const double part = now.is_explicit ? round_off_factor : solution_round_off_factor(growth);
  const double motion_part = now.is_explicit ? part : solution_round_off_factor(growth * growth);
  rest_fraction_ = std::min(max_rest_fraction, motion_part);
  compute_rate_magnitudes(now);
  propagate_motion(now);
  read_motion(seen);
  for (ForceMagnitude& size : external_sizes_) size = {};
  if (!external_.is_empty()) external_.add_magnitudes(now.state, now.time, external_sizes_);
  propagate_forces(now);
  add_in_joints(now, seen);
  compute_sums(now);
  if (!tree_.closures.empty()) {
    add_closures(now, multipliers);
    propagate_forces(now);
    add_in_joints(now, seen);
  }
  read_transmitted(now, seen);
  terms_.raise_to(now_, 1);
  grown_.raise_to(now_, part / round_off_factor);
  // What is solved for is itself found to so many digits only: idle turns of rods show it first.
  for (VectorX TermMagnitudes::*motion :
       {&TermMagnitudes::position, &TermMagnitudes::velocity, &TermMagnitudes::acceleration})
    grown_.*motion = (grown_.*motion).cwiseMax(motion_part / round_off_factor * now_.*motion);
}

template <class S>
double TermMagnitudeRecorder<S>::magnitude_of(double value, double scale) const {
  constexpr double margin = 4;  // what is made of it may add up
  const double size = std::abs(value);
  return size <= rest_fraction_ * scale ? margin / rest_fraction_ * size : size;
}

template <class S>
void TermMagnitudeRecorder<S>::compute_rate_magnitudes(const TreeMotion<S>& now) {
  for (int c = 0; c < tree_.columns; ++c) {
    const auto i = static_cast<std::size_t>(c);
    const double unit = tree_.is_length_column[i] ? tree_.characteristic_length : 1;
    dy_[i] = magnitude_of(now.dy[c], unit * rest_scale_.rate);
    ddy_[i] = magnitude_of(now.ddy[c], unit * rest_scale_.acceleration);
  }
}

/// Outwards: places, rates and accelerations.
template <class S>
void TermMagnitudeRecorder<S>::propagate_motion(const TreeMotion<S>& now) {
  nodes_[0].acceleration = gravity_;
  for (std::size_t n = 1; n < nodes_.size(); ++n) {
    const Node<S>& joint = tree_.nodes[n];
    const NodeMagnitudes& parent = nodes_[static_cast<std::size_t>(joint.parent)];
    const double arm = now.state[n].p_PN.norm();
    NodeMagnitudes& node = nodes_[n];
    node.place = parent.place + arm;
    node.turning = parent.turning;
    node.turning_rate = parent.turning_rate;
    node.speed = parent.speed + parent.turning * arm;
    node.acceleration = parent.acceleration + (parent.turning_rate + parent.turning * parent.turning) * arm;
    if (joint.motion == NodeMotion::weld) continue;
    const double rate = std::abs(joint.ratio) * dy_[joint.column],
                 rate_rate = std::abs(joint.ratio) * ddy_[joint.column];
    if (joint.motion == NodeMotion::revolute) {
      node.turning += rate;
      node.turning_rate += rate_rate;
      if constexpr (S::dimension == 3) node.turning_rate += parent.turning * rate;
    } else {
      node.speed += rate;
      node.acceleration += rate_rate + 2 * parent.turning * rate;
    }
  }
}

template <class S>
double TermMagnitudeRecorder<S>::unit(CoordinateId coordinate) const {
  return mechanism_.coordinates[static_cast<std::size_t>(coordinate)].kind == CoordinateKind::length
             ? tree_.characteristic_length
             : 1;
}

/// Of the coordinates: all are solved for together, so that one's error is measured by the largest of them.
template <class S>
void TermMagnitudeRecorder<S>::read_motion(const Sample& seen) {
  rate_ = rate_rate_ = 0;
  for (int c = 0; c < tree_.columns; ++c) {
    const double scale = tree_.is_length_column[static_cast<std::size_t>(c)] ? tree_.characteristic_length : 1;
    rate_ = std::max(rate_, dy_[static_cast<std::size_t>(c)] / scale);
    rate_rate_ = std::max(rate_rate_, ddy_[static_cast<std::size_t>(c)] / scale);
  }
  rate_rate_ = std::max(rate_rate_, rate_ * rate_);
  for (Eigen::Index c = 0; c < now_.position.size(); ++c) {
    const double scale = unit(static_cast<int>(c));
    now_.position[c] = std::max(scale, std::abs(seen.position[c]));
    now_.velocity[c] = std::max(scale * rate_, magnitude_of(seen.velocity[c], scale * rest_scale_.rate));
    now_.acceleration[c] =
        std::max(scale * rate_rate_, magnitude_of(seen.acceleration[c], scale * rest_scale_.acceleration));
  }
  if (!mechanism_.tool) return;
  now_.tool_position[0] = nodes_[static_cast<std::size_t>(tool_.node)].place + tool_.p_N.norm();
  if constexpr (S::dimension == 2) now_.tool_angle[0] = std::max(1.0, std::abs(seen.tool_angle));
}

/// What accelerates a node's bodies, about its point.
template <class S>
ForceMagnitude TermMagnitudeRecorder<S>::inertial_magnitude(const NodeMagnitudes& node) {
  const double turn = node.turning_rate + node.turning * node.turning;
  return {node.mass * node.acceleration + turn * node.first,
          (S::dimension == 2 ? node.turning_rate : turn) * node.second + node.first * node.acceleration};
}

/// Inwards: forces, moments, and what they come to along every coordinate.
template <class S>
void TermMagnitudeRecorder<S>::propagate_forces(const TreeMotion<S>& now) {
  std::fill(tau_.begin(), tau_.end(), 0);
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    NodeMagnitudes& node = nodes_[n];
    const ForceMagnitude inertia = n == 0 ? ForceMagnitude{} : inertial_magnitude(node);
    node.force = external_sizes_[n].force + inertia.force;
    node.moment = external_sizes_[n].moment + inertia.moment;
  }
  for (std::size_t n = nodes_.size(); n-- > 1;) {
    const Node<S>& joint = tree_.nodes[n];
    const NodeMagnitudes& node = nodes_[n];
    if (joint.motion != NodeMotion::weld)
      tau_[static_cast<std::size_t>(joint.column)] +=
          std::abs(joint.ratio) * (joint.motion == NodeMotion::revolute ? node.moment : node.force);
    NodeMagnitudes& parent = nodes_[static_cast<std::size_t>(joint.parent)];
    parent.force += node.force;
    parent.moment += node.moment + now.state[n].p_PN.norm() * node.force;
  }
}

/// Friction and springs in joint coordinates.
template <class S>
void TermMagnitudeRecorder<S>::add_in_joints(const TreeMotion<S>& now, const Sample& seen) {
  external_.add_joint_magnitudes(now.y, tau_);
  for (const Friction& friction : mechanism_.friction) {
    const double rate = std::abs(seen.velocity[friction.coordinate]);
    for (const auto& [column, ratio] :
         tree_.coordinate_expressions[static_cast<std::size_t>(friction.coordinate)].terms)
      tau_[static_cast<std::size_t>(column)] +=
          std::abs(ratio) * (friction.viscous * rate + std::max(friction.static_limit(1), friction.static_limit(-1)));
  }
}

/// What is summed over all nodes.
template <class S>
void TermMagnitudeRecorder<S>::compute_sums(const TreeMotion<S>& now) {
  double place = 0, momentum = 0, energy = 0;
  auto [force, moment] = external_.sum_magnitudes(now.state, now.time);
  for (const NodeMagnitudes& node : nodes_) {
    const ForceMagnitude inertia = inertial_magnitude(node);
    force += inertia.force;
    moment += inertia.moment + node.place * inertia.force;
    const double spin = node.turning * node.first;
    place += node.mass * node.place + node.first;
    momentum += node.mass * node.speed + spin;
    energy +=
        0.5 * node.mass * node.speed * node.speed + node.speed * spin + 0.5 * node.turning * node.turning * node.second;
  }
  now_.com_position[0] = place / tree_.mass;
  now_.com_velocity[0] = momentum / tree_.mass;
  now_.shaking_force[0] = force;
  now_.shaking_moment[0] = moment + about_ * force;
  now_.moment_com[0] = now_.shaking_moment[0] + (now_.com_position[0] + about_) * force;
  now_.force[0] = nodes_[0].force;
  now_.moment[0] = nodes_[0].moment + about_ * nodes_[0].force;
  now_.com_acceleration[0] = force / tree_.mass;
  now_.kinetic_energy[0] = energy;
  now_.potential_energy[0] = gravity_ * place + external_.energy_magnitude(now.state, now.y);
}

/// The closures' wrenches join the external ones. A multiplier is measured by itself and by all the forces that it is solved
/// from.
template <class S>
void TermMagnitudeRecorder<S>::add_closures(const TreeMotion<S>& now, const std::vector<double>& multipliers) {
  double all = 0;
  for (int c = 0; c < tree_.columns; ++c)
    all += tau_[static_cast<std::size_t>(c)] *
           (tree_.is_length_column[static_cast<std::size_t>(c)] ? tree_.characteristic_length : 1);
  std::size_t r = 0;
  Eigen::Index constraint = 0;
  for (const Closure<S>& closure : tree_.closures) {
    ForceMagnitude size;
    if (!closure.terms.empty()) {
      const double multiplier = std::abs(multipliers[r++]) + all / closure.row_scale;
      now_.constraint_force[constraint++] = multiplier;
      for (const VelocityTerm<S>& term : closure.terms)
        if (term.of != VelocityTerm<S>::Of::column)
          add_constraint_wrench(now, term, multiplier * std::abs(term.factor));
      continue;
    }
    for (const ClosureRow& row : closure.rows) {
      const double multiplier = std::abs(multipliers[r++]);
      if (row.kind != ClosureRow::Kind::dot)
        size.force += multiplier + all / tree_.characteristic_length;
      else
        size.moment += multiplier + all;
    }
    if (!closure.split) {
      now_.joint_force[closure.joint] = size.force;
      now_.joint_moment[closure.joint] = size.moment;
    }
    const typename S::Vector Q = position(now.state, closure.b);
    for (const int n : {closure.a.node, closure.b.node}) {
      if (n == 0) continue;
      ForceMagnitude& sum = external_sizes_[static_cast<std::size_t>(n)];
      sum.force += size.force;
      sum.moment += size.moment + (Q - now.state[static_cast<std::size_t>(n)].p_WN).norm() * size.force;
    }
  }
}

/// By a constraint of so much, on what it binds.
template <class S>
void TermMagnitudeRecorder<S>::add_constraint_wrench(const TreeMotion<S>& now, const VelocityTerm<S>& term,
                                                     double size) {
  const auto node = static_cast<std::size_t>(term.frame.node);
  if (node == 0) return;
  ForceMagnitude& sum = external_sizes_[node];
  if (term.of == VelocityTerm<S>::Of::angular_velocity) {
    sum.moment += size;
    return;
  }
  sum.force += size;
  sum.moment += (position(now.state, term.frame) - now.state[node].p_WN).norm() * size;
}

/// What joints and actuators transmit.
template <class S>
void TermMagnitudeRecorder<S>::read_transmitted(const TreeMotion<S>& now, const Sample& seen) {
  for (std::size_t a = 0; a < mechanism_.actuators.size(); ++a) {
    const CoordinateId coordinate = mechanism_.actuators[a];
    const auto i = static_cast<Eigen::Index>(a);
    now_.effort[i] = std::abs(seen.effort[i]);
    for (const auto& [column, ratio] : tree_.coordinate_expressions[static_cast<std::size_t>(coordinate)].terms)
      if (ratio != 0) now_.effort[i] += tau_[static_cast<std::size_t>(column)] / std::abs(ratio);
    now_.power[i] = now_.effort[i] * now_.velocity[coordinate];
  }
  now_.total_effort[0] = now_.effort.norm();
  for (std::size_t j = 0; j < mechanism_.joints.size(); ++j) {
    const int n = tree_.joint_nodes[j];
    if (n < 0) continue;
    const auto i = static_cast<Eigen::Index>(j);
    const auto node = static_cast<std::size_t>(n);
    const FixedFrame<S>& second = tree_.bodies[static_cast<std::size_t>(mechanism_.joints[j].second)];
    const typename S::Vector Q =
        position(now.state,
                 {second.node, second.R_N, second.p_N + second.R_N * to_vector<S>(mechanism_.joints[j].point_second)});
    if (!is_rolling(mechanism_.joints[j].type)) now_.joint_force[i] = now_.joint_moment[i] = 0;
    now_.joint_force[i] += nodes_[node].force;
    now_.joint_moment[i] += nodes_[node].moment + (Q - now.state[node].p_WN).norm() * nodes_[node].force;
  }
}

template class TermMagnitudeRecorder<Planar>;
template class TermMagnitudeRecorder<Spatial>;

}  // namespace balance
