#include "balance/mechanics/dynamics/term_magnitude_recorder.hpp"

#include <algorithm>
#include <cmath>

namespace balance::dynamics {

namespace {

/// Relative uncertainty of what equations are solved for: their residual is reduced to 1e-12, and round-off grows with
/// the inverse of the mobility, or its square.
double solution_round_off_factor(double amplification) {
  return std::max(1e-12, 8 * results::round_off_factor * amplification);
}

/// Rates above this fraction of the rest scale count as rates even near a singularity.
constexpr double max_rest_fraction = 1e-6;

}  // namespace

template <class S>
TermMagnitudeRecorder<S>::TermMagnitudeRecorder(const Mechanism& mechanism, const kinematics::Tree<S>& tree,
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
      external_magnitudes_(tree.nodes.size()) {
  for (const kinematics::MassElement<S>& element : tree.mass_elements) {
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
  for (auto* values : {&current_.position, &current_.velocity, &current_.acceleration})
    values->setZero(size(mechanism.coordinates));
  for (auto* values : {&current_.effort, &current_.power}) values->setZero(size(mechanism.actuators));
  for (auto* values : {&current_.joint_force, &current_.joint_moment}) values->setZero(size(mechanism.joints));
  for (auto* values : {&current_.constraint_force, &current_.constraint_power})
    values->setZero(size(mechanism.constraints));
  for (auto* value :
       {&current_.com_position, &current_.com_velocity, &current_.com_acceleration, &current_.shaking_force,
        &current_.shaking_moment, &current_.force, &current_.moment, &current_.moment_com, &current_.total_effort,
        &current_.kinetic_energy, &current_.potential_energy})
    value->setZero(1);
  if (!mechanism.tool) return;
  current_.tool_position.setZero(1);
  current_.tool_angle.setOnes(1);
  const kinematics::FixedFrame<S>& body = tree.bodies[static_cast<std::size_t>(mechanism.tool->body)];
  tool_ = {body.node, body.R_N, body.p_N + body.R_N * kinematics::to_vector<S>(mechanism.tool->position)};
}

template <class S>
void TermMagnitudeRecorder<S>::sample(const TreeMotion<S>& motion, const Sample& sample,
                                      const std::vector<double>& multipliers, double mobility) {
  const double amplification = mobility < 1 ? 1 / std::max(mobility, 1e-12) : 1;
  const double relative_uncertainty =
      motion.is_explicit ? results::round_off_factor : solution_round_off_factor(amplification);
  const double motion_uncertainty =
      motion.is_explicit ? relative_uncertainty : solution_round_off_factor(amplification * amplification);
  rest_fraction_ = std::min(max_rest_fraction, motion_uncertainty);
  compute_rate_magnitudes(motion);
  propagate_motion(motion);
  read_motion(sample);
  for (ForceMagnitude& size : external_magnitudes_) size = {};
  if (!external_.is_empty()) external_.add_magnitudes(motion.state, motion.y, motion.time, external_magnitudes_);
  propagate_forces(motion);
  add_in_joints(motion, sample);
  compute_sums(motion);
  if (!tree_.closures.empty()) {
    add_closures(motion, multipliers);
    propagate_forces(motion);
    add_in_joints(motion, sample);
  }
  read_transmitted(motion, sample);
  terms_.raise_to(current_, 1);
  amplified_.raise_to(current_, relative_uncertainty / results::round_off_factor);
  // Coordinates that are solved for are only accurate to so many digits; passive rotations of rods show it first.
  for (VectorX results::TermMagnitudes::*member :
       {&results::TermMagnitudes::position, &results::TermMagnitudes::velocity, &results::TermMagnitudes::acceleration})
    amplified_.*member =
        (amplified_.*member).cwiseMax(motion_uncertainty / results::round_off_factor * current_.*member);
}

template <class S>
double TermMagnitudeRecorder<S>::magnitude_of(double value, double scale) const {
  constexpr double margin = 4;  // terms computed from it may add up
  const double size = std::abs(value);
  return size <= rest_fraction_ * scale ? margin / rest_fraction_ * size : size;
}

template <class S>
void TermMagnitudeRecorder<S>::compute_rate_magnitudes(const TreeMotion<S>& motion) {
  for (int c = 0; c < tree_.columns; ++c) {
    const auto i = static_cast<std::size_t>(c);
    const double unit = tree_.is_length_column[i] ? tree_.characteristic_length : 1;
    dy_[i] = magnitude_of(motion.dy[c], unit * rest_scale_.rate);
    ddy_[i] = magnitude_of(motion.ddy[c], unit * rest_scale_.acceleration);
  }
}

/// Outward pass: positions, rates and accelerations.
template <class S>
void TermMagnitudeRecorder<S>::propagate_motion(const TreeMotion<S>& motion) {
  nodes_[0].acceleration = gravity_;
  for (std::size_t n = 1; n < nodes_.size(); ++n) {
    const kinematics::Node<S>& joint = tree_.nodes[n];
    const NodeMagnitudes& parent = nodes_[static_cast<std::size_t>(joint.parent)];
    const double arm = motion.state[n].p_PN.norm();
    NodeMagnitudes& node = nodes_[n];
    node.distance = parent.distance + arm;
    node.angular_velocity = parent.angular_velocity;
    node.angular_acceleration = parent.angular_acceleration;
    node.speed = parent.speed + parent.angular_velocity * arm;
    node.acceleration =
        parent.acceleration + (parent.angular_acceleration + parent.angular_velocity * parent.angular_velocity) * arm;
    if (joint.motion == kinematics::NodeMotion::weld) continue;
    const double rate = std::abs(joint.ratio) * dy_[joint.column],
                 acceleration = std::abs(joint.ratio) * ddy_[joint.column];
    if (joint.motion == kinematics::NodeMotion::revolute) {
      node.angular_velocity += rate;
      node.angular_acceleration += acceleration;
      if constexpr (S::dimension == 3) node.angular_acceleration += parent.angular_velocity * rate;
    } else {
      node.speed += rate;
      node.acceleration += acceleration + 2 * parent.angular_velocity * rate;
    }
  }
}

template <class S>
double TermMagnitudeRecorder<S>::unit(CoordinateId coordinate) const {
  return mechanism_.coordinates[static_cast<std::size_t>(coordinate)].kind == CoordinateKind::length
             ? tree_.characteristic_length
             : 1;
}

/// Magnitudes of the coordinates. All are solved for together, so the error of each is relative to the largest of them.
template <class S>
void TermMagnitudeRecorder<S>::read_motion(const Sample& sample) {
  max_rate_ = max_acceleration_ = 0;
  for (int c = 0; c < tree_.columns; ++c) {
    const double scale = tree_.is_length_column[static_cast<std::size_t>(c)] ? tree_.characteristic_length : 1;
    max_rate_ = std::max(max_rate_, dy_[static_cast<std::size_t>(c)] / scale);
    max_acceleration_ = std::max(max_acceleration_, ddy_[static_cast<std::size_t>(c)] / scale);
  }
  max_acceleration_ = std::max(max_acceleration_, max_rate_ * max_rate_);
  for (Eigen::Index c = 0; c < current_.position.size(); ++c) {
    const double scale = unit(static_cast<int>(c));
    current_.position[c] = std::max(scale, std::abs(sample.position[c]));
    current_.velocity[c] = std::max(scale * max_rate_, magnitude_of(sample.velocity[c], scale * rest_scale_.rate));
    current_.acceleration[c] =
        std::max(scale * max_acceleration_, magnitude_of(sample.acceleration[c], scale * rest_scale_.acceleration));
  }
  if (!mechanism_.tool) return;
  current_.tool_position[0] = nodes_[static_cast<std::size_t>(tool_.node)].distance + tool_.p_N.norm();
  if constexpr (S::dimension == 2) current_.tool_angle[0] = std::max(1.0, std::abs(sample.tool_angle));
}

/// Magnitudes of the wrench that accelerates a node's bodies, about its origin.
template <class S>
ForceMagnitude TermMagnitudeRecorder<S>::inertial_magnitude(const NodeMagnitudes& node) {
  const double rotational_acceleration = node.angular_acceleration + node.angular_velocity * node.angular_velocity;
  return {node.mass * node.acceleration + rotational_acceleration * node.first,
          (S::dimension == 2 ? node.angular_acceleration : rotational_acceleration) * node.second +
              node.first * node.acceleration};
}

/// Inward pass: forces, moments, and the generalised forces along every coordinate.
template <class S>
void TermMagnitudeRecorder<S>::propagate_forces(const TreeMotion<S>& motion) {
  std::fill(tau_.begin(), tau_.end(), 0);
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    NodeMagnitudes& node = nodes_[n];
    const ForceMagnitude inertia = n == 0 ? ForceMagnitude{} : inertial_magnitude(node);
    node.force = external_magnitudes_[n].force + inertia.force;
    node.moment = external_magnitudes_[n].moment + inertia.moment;
  }
  for (std::size_t n = nodes_.size(); n-- > 1;) {
    const kinematics::Node<S>& joint = tree_.nodes[n];
    const NodeMagnitudes& node = nodes_[n];
    if (joint.motion != kinematics::NodeMotion::weld)
      tau_[static_cast<std::size_t>(joint.column)] +=
          std::abs(joint.ratio) * (joint.motion == kinematics::NodeMotion::revolute ? node.moment : node.force);
    NodeMagnitudes& parent = nodes_[static_cast<std::size_t>(joint.parent)];
    parent.force += node.force;
    parent.moment += node.moment + motion.state[n].p_PN.norm() * node.force;
  }
}

/// Friction and springs in joint coordinates.
template <class S>
void TermMagnitudeRecorder<S>::add_in_joints(const TreeMotion<S>& motion, const Sample& sample) {
  external_.add_joint_magnitudes(motion.y, tau_);
  for (const Friction& friction : mechanism_.friction) {
    const double rate = std::abs(sample.velocity[friction.coordinate]);
    for (const auto& [column, ratio] :
         tree_.coordinate_expressions[static_cast<std::size_t>(friction.coordinate)].terms)
      tau_[static_cast<std::size_t>(column)] +=
          std::abs(ratio) * (friction.viscous * rate + std::max(friction.static_limit(1), friction.static_limit(-1)));
  }
}

/// Quantities that are sums over all nodes.
template <class S>
void TermMagnitudeRecorder<S>::compute_sums(const TreeMotion<S>& motion) {
  double first_moment = 0, momentum = 0, energy = 0;
  auto [force, moment] = external_.sum_magnitudes(motion.state, motion.y, motion.time);
  for (const NodeMagnitudes& node : nodes_) {
    const ForceMagnitude inertia = inertial_magnitude(node);
    force += inertia.force;
    moment += inertia.moment + node.distance * inertia.force;
    const double rotation = node.angular_velocity * node.first;
    first_moment += node.mass * node.distance + node.first;
    momentum += node.mass * node.speed + rotation;
    energy += 0.5 * node.mass * node.speed * node.speed + node.speed * rotation +
              0.5 * node.angular_velocity * node.angular_velocity * node.second;
  }
  current_.com_position[0] = first_moment / tree_.mass;
  current_.com_velocity[0] = momentum / tree_.mass;
  current_.shaking_force[0] = force;
  current_.shaking_moment[0] = moment + about_ * force;
  current_.moment_com[0] = current_.shaking_moment[0] + (current_.com_position[0] + about_) * force;
  current_.force[0] = nodes_[0].force;
  current_.moment[0] = nodes_[0].moment + about_ * nodes_[0].force;
  current_.com_acceleration[0] = force / tree_.mass;
  current_.kinetic_energy[0] = energy;
  current_.potential_energy[0] = gravity_ * first_moment + external_.energy_magnitude(motion.state, motion.y);
}

/// Adds the closures' wrenches to the external ones. A multiplier counts with its own magnitude and with those of all
/// forces from which it is solved.
template <class S>
void TermMagnitudeRecorder<S>::add_closures(const TreeMotion<S>& motion, const std::vector<double>& multipliers) {
  double total_force = 0;
  for (int c = 0; c < tree_.columns; ++c)
    total_force += tau_[static_cast<std::size_t>(c)] *
                   (tree_.is_length_column[static_cast<std::size_t>(c)] ? tree_.characteristic_length : 1);
  std::size_t r = 0;
  Eigen::Index constraint = 0;
  for (const kinematics::Closure<S>& closure : tree_.closures) {
    ForceMagnitude size;
    if (!closure.terms.empty()) {
      const double multiplier = std::abs(multipliers[r++]) + total_force / closure.row_scale;
      current_.constraint_force[constraint] = multiplier;
      current_.constraint_power[constraint++] =
          multiplier * std::abs(model::evaluate_at_time(closure.value, motion.time).value);
      for (const kinematics::VelocityTerm<S>& term : closure.terms)
        if (term.of != kinematics::VelocityTerm<S>::Of::column)
          add_constraint_wrench(motion, term, multiplier * std::abs(term.factor));
      continue;
    }
    for (const kinematics::ClosureRow& row : closure.rows) {
      const double multiplier = std::abs(multipliers[r++]);
      if (row.kind != kinematics::ClosureRow::Kind::dot)
        size.force += multiplier + total_force / tree_.characteristic_length;
      else
        size.moment += multiplier + total_force;
    }
    if (!closure.split) {
      current_.joint_force[closure.joint] = size.force;
      current_.joint_moment[closure.joint] = size.moment;
    }
    const typename S::Vector Q = position(motion.state, closure.b);
    for (const int n : {closure.a.node, closure.b.node}) {
      if (n == 0) continue;
      ForceMagnitude& sum = external_magnitudes_[static_cast<std::size_t>(n)];
      sum.force += size.force;
      sum.moment += size.moment + (Q - motion.state[static_cast<std::size_t>(n)].p_WN).norm() * size.force;
    }
  }
}

/// Adds the wrench of a constraint force of this size on the body of one of its terms.
template <class S>
void TermMagnitudeRecorder<S>::add_constraint_wrench(const TreeMotion<S>& motion,
                                                     const kinematics::VelocityTerm<S>& term, double magnitude) {
  const auto node = static_cast<std::size_t>(term.frame.node);
  if (node == 0) return;
  ForceMagnitude& sum = external_magnitudes_[node];
  if (term.of == kinematics::VelocityTerm<S>::Of::angular_velocity) {
    sum.moment += magnitude;
    return;
  }
  sum.force += magnitude;
  sum.moment += (position(motion.state, term.frame) - motion.state[node].p_WN).norm() * magnitude;
}

/// Reactions of the joints and efforts of the actuators.
template <class S>
void TermMagnitudeRecorder<S>::read_transmitted(const TreeMotion<S>& motion, const Sample& sample) {
  for (std::size_t a = 0; a < mechanism_.actuators.size(); ++a) {
    const CoordinateId coordinate = mechanism_.actuators[a];
    const auto i = static_cast<Eigen::Index>(a);
    current_.effort[i] = std::abs(sample.effort[i]);
    for (const auto& [column, ratio] : tree_.coordinate_expressions[static_cast<std::size_t>(coordinate)].terms)
      if (ratio != 0) current_.effort[i] += tau_[static_cast<std::size_t>(column)] / std::abs(ratio);
    current_.power[i] = current_.effort[i] * current_.velocity[coordinate];
  }
  current_.total_effort[0] = current_.effort.norm();
  for (std::size_t j = 0; j < mechanism_.joints.size(); ++j) {
    const int n = tree_.joint_nodes[j];
    if (n < 0) continue;
    const auto i = static_cast<Eigen::Index>(j);
    const auto node = static_cast<std::size_t>(n);
    const kinematics::FixedFrame<S>& second = tree_.bodies[static_cast<std::size_t>(mechanism_.joints[j].second)];
    const typename S::Vector Q = kinematics::position(
        motion.state, {second.node, second.R_N,
                       second.p_N + second.R_N * kinematics::to_vector<S>(mechanism_.joints[j].point_second)});
    if (!is_rolling(mechanism_.joints[j].type)) current_.joint_force[i] = current_.joint_moment[i] = 0;
    current_.joint_force[i] += nodes_[node].force;
    current_.joint_moment[i] += nodes_[node].moment + (Q - motion.state[node].p_WN).norm() * nodes_[node].force;
  }
}

template class TermMagnitudeRecorder<kinematics::Planar>;
template class TermMagnitudeRecorder<kinematics::Spatial>;

}  // namespace balance::dynamics
