// Speeds as rows over the independent coordinates' rates, and what rates make of their derivatives.

#include "balance/equations/engine.hpp"
#include "balance/equations/polarised.hpp"

#include <stdexcept>

namespace balance {

namespace {

/// A component of a body's motion, or its rate of change. Components v in axes R that turn at w change by Rᵀ (v̇ − w × v).
template <class S>
double compute_speed_component(const TreeState<S>& state, const FixedFrame<S>& body, const GeneralisedSpeedTerm& term,
                               bool derivative) {
  using enum GeneralisedSpeedTerm::Kind;
  const NodeState<S>& node = state[static_cast<std::size_t>(body.node)];
  const Vector3 w = angular_to_3d(typename S::Angular(node.R_WN * node.angular_velocity));
  Vector3 value;
  if (term.kind == angular_velocity || term.kind == angular_velocity_body) {
    value = derivative ? angular_to_3d(typename S::Angular(node.R_WN * node.angular_acceleration)) : w;
  } else {
    const typename S::Vector p_N = body.p_N + body.R_N * to_vector<S>(term.position);
    const Vector3 v = to_3d(point_velocity<S>(node, p_N));
    value = !derivative ? v : to_3d(point_acceleration<S>(node, p_N));
    if (derivative && term.kind == velocity_body) value -= w.cross(v);
  }
  const bool own = term.kind == velocity_body || term.kind == angular_velocity_body;
  return own ? to_matrix(orientation(state, body)).col(term.index).dot(value) : value[term.index];
}

/// @throws std::invalid_argument
template <class S>
void check_speeds(const Mechanism& mechanism, const Tree<S>& tree, const std::vector<GeneralisedSpeed>& speeds) {
  for (const GeneralisedSpeed& speed : speeds)
    for (const GeneralisedSpeedTerm& term : speed.terms) {
      if (term.kind != GeneralisedSpeedTerm::Kind::coordinate) {
        if (term.body < 0 || term.body >= static_cast<int>(tree.bodies.size()) || term.index < 0 || term.index > 2)
          throw std::invalid_argument("the speed " + speed.name + " is one of a body or an axis that does not exist");
        continue;
      }
      const auto c = static_cast<std::size_t>(term.index);
      const Coordinate& coordinate = mechanism.coordinates.at(c);
      if (!tree.coordinate_expressions[c].has_terms() || tree.is_floating[c])
        throw std::invalid_argument("the speed " + speed.name + " cannot be made of " + coordinate.name +
                                    ", whose joint closes a loop or floats; make it independent, or take others");
    }
}

/// @param dy rates, or accelerations, of the tree's coordinates @param state moves with them
template <class S>
VectorX evaluate_speeds(const std::vector<GeneralisedSpeed>& speeds, const Tree<S>& tree, const double* dy,
                        const TreeState<S>& state, bool derivative) {
  VectorX values = VectorX::Zero(static_cast<Eigen::Index>(speeds.size()));
  for (std::size_t i = 0; i < speeds.size(); ++i)
    for (const GeneralisedSpeedTerm& term : speeds[i].terms)
      values[static_cast<Eigen::Index>(i)] +=
          term.factor *
          (term.kind == GeneralisedSpeedTerm::Kind::coordinate
               ? tree.coordinate_expressions[static_cast<std::size_t>(term.index)].rate(dy)
               : compute_speed_component(state, tree.bodies[static_cast<std::size_t>(term.body)], term, derivative));
  return values;
}

}  // namespace

template <class S>
MotionOutcome EquationTermsOf<S>::speed_rows(const double* q, const std::vector<GeneralisedSpeed>& speeds,
                                             MatrixX& rows, std::vector<MatrixX>& forms) {
  if (MotionOutcome outcome = move_to(q); outcome.status != MotionStatus::done) return outcome;
  const Tree<S>& tree = branch_.tree();
  check_speeds(mechanism, tree, speeds);
  TreeState<S>& state = branch_.state();
  rows.resize(static_cast<Eigen::Index>(speeds.size()), freedoms_);
  for (int k = 0; k < freedoms_; ++k) {
    const VectorX dy = C_.col(k);
    compute_velocities(tree, dy.data(), state);
    rows.col(k) = evaluate_speeds(speeds, tree, dy.data(), state, false);
  }
  forms = polarise_quadratic_form(freedoms_, [&](const VectorX& rates) {
    VectorX dy;
    const VectorX ddy = compute_velocity_product_acceleration(rates, dy);
    compute_velocities(tree, dy.data(), state);
    compute_accelerations<S>(tree, dy.data(), ddy.data(), S::Vector::Zero(), state);
    return evaluate_speeds(speeds, tree, ddy.data(), state, true);
  });
  return {MotionStatus::done, 0, "", {}};
}

template MotionOutcome EquationTermsOf<Planar>::speed_rows(const double*, const std::vector<GeneralisedSpeed>&,
                                                           MatrixX&, std::vector<MatrixX>&);
template MotionOutcome EquationTermsOf<Spatial>::speed_rows(const double*, const std::vector<GeneralisedSpeed>&,
                                                            MatrixX&, std::vector<MatrixX>&);

}  // namespace balance
