// Speeds as rows over the independent coordinates' rates, and what rates make of their derivatives.

#include "balance/equations/engine.hpp"
#include "balance/equations/polarised.hpp"

#include <stdexcept>

namespace balance {

namespace {

/// A speed, or its rate of change.
struct ToolRates {
  Vector3 velocity, velocity_own, turning, turning_own;

  double of(const SpeedTerm& term) const {
    switch (term.of) {
      case SpeedTerm::Of::tool_velocity: return velocity[term.index];
      case SpeedTerm::Of::tool_velocity_own: return velocity_own[term.index];
      case SpeedTerm::Of::tool_turning: return turning[term.index];
      case SpeedTerm::Of::tool_turning_own: return turning_own[term.index];
      case SpeedTerm::Of::coordinate: break;
    }
    return 0;
  }
};

/// Components v in axes R that turn at w change by Rᵀ (v̇ − w × v).
template <class S>
ToolRates tool_rates(const State<S>& state, const FixedFrame<S>& tool, bool derivative) {
  const NodeState<S>& node = state[static_cast<std::size_t>(tool.node)];
  const Matrix3 R = to_matrix(orientation(state, tool));
  const Vector3 v = to_3d(point_velocity<S>(node, tool.p_N));
  const Vector3 w = angular_to_3d(typename S::Angular(node.R_WN * node.angular_velocity));
  if (!derivative) return {v, R.transpose() * v, w, R.transpose() * w};
  const Vector3 a = to_3d(point_acceleration<S>(node, tool.p_N));
  const Vector3 alpha = angular_to_3d(typename S::Angular(node.R_WN * node.angular_acceleration));
  return {a, R.transpose() * (a - w.cross(v)), alpha, R.transpose() * alpha};
}

bool asks_tool(const std::vector<Speed>& speeds) {
  for (const Speed& speed : speeds)
    for (const SpeedTerm& term : speed.terms)
      if (term.of != SpeedTerm::Of::coordinate) return true;
  return false;
}

/// @throws std::invalid_argument
template <class S>
void check_speeds(const Mechanism& mechanism, const Tree<S>& tree, const std::vector<Speed>& speeds) {
  if (asks_tool(speeds) && !mechanism.tool)
    throw std::invalid_argument("speeds of the tool need a tool, which the mechanism lacks");
  for (const Speed& speed : speeds)
    for (const SpeedTerm& term : speed.terms) {
      if (term.of != SpeedTerm::Of::coordinate) continue;
      const auto c = static_cast<std::size_t>(term.index);
      const Coordinate& coordinate = mechanism.coordinates.at(c);
      if (!tree.sources[c].depends() || tree.joint_floats[static_cast<std::size_t>(coordinate.joint)])
        throw std::invalid_argument("the speed " + speed.name + " cannot be made of " + coordinate.name +
                                    ", whose joint closes a loop or floats; make it independent, or take others");
    }
}

/// @param dy rates, or accelerations, of the tree's coordinates
template <class S>
VectorX sums(const std::vector<Speed>& speeds, const Tree<S>& tree, const double* dy, const ToolRates& tool) {
  VectorX values = VectorX::Zero(static_cast<Eigen::Index>(speeds.size()));
  for (std::size_t i = 0; i < speeds.size(); ++i)
    for (const SpeedTerm& term : speeds[i].terms)
      values[static_cast<Eigen::Index>(i)] +=
          term.factor * (term.of == SpeedTerm::Of::coordinate
                             ? tree.sources[static_cast<std::size_t>(term.index)].rate(dy)
                             : tool.of(term));
  return values;
}

}  // namespace

template <class S>
MotionOutcome TermsEngine<S>::speed_rows(const double* q, const std::vector<Speed>& speeds, MatrixX& rows,
                                         std::vector<MatrixX>& forms) {
  if (MotionOutcome outcome = go(q); outcome.status != MotionStatus::done) return outcome;
  const Tree<S>& tree = branch_.tree();
  check_speeds(mechanism, tree, speeds);
  State<S>& state = branch_.state();
  Drive<S> drive;
  if (mechanism.tool) attach_tool(mechanism, tree, drive);
  const bool tool = asks_tool(speeds);
  rows.resize(static_cast<Eigen::Index>(speeds.size()), freedoms_);
  for (int k = 0; k < freedoms_; ++k) {
    const VectorX dy = C_.col(k);
    velocities(tree, dy.data(), state);
    rows.col(k) = sums(speeds, tree, dy.data(), tool ? tool_rates(state, drive.tool, false) : ToolRates());
  }
  forms = polarised(freedoms_, [&](const VectorX& rates) {
    VectorX dy;
    const VectorX ddy = acceleration_at(rates, dy);
    velocities(tree, dy.data(), state);
    accelerations<S>(tree, dy.data(), ddy.data(), S::Vector::Zero(), state);
    return sums(speeds, tree, ddy.data(), tool ? tool_rates(state, drive.tool, true) : ToolRates());
  });
  return {MotionStatus::done, 0, "", {}};
}

template MotionOutcome TermsEngine<Planar>::speed_rows(const double*, const std::vector<Speed>&, MatrixX&,
                                                       std::vector<MatrixX>&);
template MotionOutcome TermsEngine<Spatial>::speed_rows(const double*, const std::vector<Speed>&, MatrixX&,
                                                        std::vector<MatrixX>&);

}  // namespace balance
