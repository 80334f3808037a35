#pragma once
/// Values of generalised speeds and of their time derivatives in a motion of a tree.

#include "balance/mechanics/kinematics/drive.hpp"
#include "balance/mechanics/kinematics/forward_kinematics.hpp"
#include "balance/mechanics/model/mechanism.hpp"

#include <stdexcept>
#include <string>
#include <vector>

namespace balance::dynamics {

/// A component of a body's velocity, or its derivative. Components of v in axes R that rotate at w have the derivative
/// Rᵀ (v̇ − w × v).
template <class S>
double compute_speed_component(const kinematics::TreeState<S>& state, const kinematics::FixedFrame<S>& body,
                               const model::GeneralisedSpeedTerm& term, bool derivative) {
  using enum model::GeneralisedSpeedTerm::Kind;
  const kinematics::NodeState<S>& node = state[static_cast<std::size_t>(body.node)];
  const Vector3 w = kinematics::angular_to_3d(typename S::Angular(node.R_WN * node.angular_velocity));
  Vector3 value;
  if (term.kind == angular_velocity || term.kind == angular_velocity_body) {
    value = derivative ? kinematics::angular_to_3d(typename S::Angular(node.R_WN * node.angular_acceleration)) : w;
  } else {
    const typename S::Vector p_N = body.p_N + body.R_N * kinematics::to_vector<S>(term.position);
    const Vector3 v = kinematics::to_3d(kinematics::point_velocity<S>(node, p_N));
    value = !derivative ? v : kinematics::to_3d(kinematics::point_acceleration<S>(node, p_N));
    if (derivative && term.kind == velocity_body) value -= w.cross(v);
  }
  const bool is_in_body_axes = term.kind == velocity_body || term.kind == angular_velocity_body;
  return is_in_body_axes ? to_matrix(orientation(state, body)).col(term.index).dot(value) : value[term.index];
}

/// @throws std::invalid_argument if the joint of the coordinate closes a loop
template <class S>
void check_speed_coordinate(const Mechanism& mechanism, const kinematics::Tree<S>& tree, const std::string& speed,
                            int index) {
  const auto c = static_cast<std::size_t>(index);
  const Coordinate& coordinate = mechanism.coordinates.at(c);
  if (!tree.coordinate_expressions[c].has_terms() || tree.is_floating[c])
    throw std::invalid_argument("the speed " + speed + " cannot contain " + coordinate.name +
                                ", whose joint closes a loop or floats; make it independent or use others");
}

/// @throws std::invalid_argument if a body, an axis or a coordinate cannot be used
template <class S>
void check_speeds(const Mechanism& mechanism, const kinematics::Tree<S>& tree,
                  const std::vector<model::GeneralisedSpeed>& speeds) {
  using enum model::GeneralisedSpeedTerm::Kind;
  for (const model::GeneralisedSpeed& speed : speeds)
    for (const model::GeneralisedSpeedTerm& term : speed.terms) {
      for (const CoordinateId c : term.pose_variables) check_speed_coordinate(mechanism, tree, speed.name, c);
      if (term.kind == coordinate)
        check_speed_coordinate(mechanism, tree, speed.name, term.index);
      else if (term.body < 0 || term.body >= static_cast<int>(tree.bodies.size()) || term.index < 0 || term.index > 2)
        throw std::invalid_argument("the speed " + speed.name + " refers to a body or an axis that does not exist");
      if (term.kind == com_velocity && !(tree.mass > 0))
        throw std::invalid_argument("the speed " + speed.name + " is that of the centre of mass, but nothing has mass");
    }
}

/// A motion of the tree: its coordinates, rates and accelerations, with the state of the same motion.
template <class S>
struct SpeedProbe {
  const kinematics::Tree<S>& tree;
  const kinematics::TreeState<S>& state;
  const double *y, *dy, *ddy;

  double component(const model::GeneralisedSpeedTerm& term, bool derivative) const {
    using enum model::GeneralisedSpeedTerm::Kind;
    if (term.kind == coordinate)
      return tree.coordinate_expressions[static_cast<std::size_t>(term.index)].rate(derivative ? ddy : dy);
    if (term.kind == com_velocity)
      return kinematics::to_3d(derivative ? kinematics::com_acceleration(tree, state)
                                          : kinematics::com_velocity(tree, state))[term.index];
    return compute_speed_component(state, tree.bodies[static_cast<std::size_t>(term.body)], term, derivative);
  }
  model::ValueAndRate factor(const model::GeneralisedSpeedTerm& term) const {
    if (!term.pose_factor) return {term.factor, 0};
    std::vector<double> positions, rates;
    for (const CoordinateId c : term.pose_variables) {
      positions.push_back(tree.coordinate_expressions[static_cast<std::size_t>(c)].value(y));
      rates.push_back(tree.coordinate_expressions[static_cast<std::size_t>(c)].rate(dy));
    }
    const model::ValueAndRate f = evaluate(term.pose_factor, positions, rates);
    return {term.factor * f.value, term.factor * f.rate};
  }
  /// The speeds, or their time derivatives.
  VectorX evaluate_speeds(const std::vector<model::GeneralisedSpeed>& speeds, bool derivative) const {
    VectorX values = VectorX::Zero(static_cast<Eigen::Index>(speeds.size()));
    for (std::size_t i = 0; i < speeds.size(); ++i)
      for (const model::GeneralisedSpeedTerm& term : speeds[i].terms) {
        const model::ValueAndRate f = factor(term);
        double& value = values[static_cast<Eigen::Index>(i)];
        value += f.value * component(term, derivative);
        if (derivative && term.pose_factor) value += f.rate * component(term, false);
      }
    return values;
  }
};

}  // namespace balance::dynamics
