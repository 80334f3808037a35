#include "balance/kinematics/rate_closures.hpp"

#include "balance/base/number.hpp"
#include "balance/kinematics/joint_steps.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

namespace {

template <class S>
void grow_row_scale(const typename S::Scalar& factor, double size, Closure<S>& closure) {
  const double most = std::abs(value_of(factor)) * size;
  closure.row_scale = closure.terms.size() == 1 ? most : std::max(closure.row_scale, most);
}

/// As many terms as columns that the coordinate follows.
template <class S>
void add_coordinate_rate(const Tree<S>& tree, const GeneralisedSpeedTermOf<typename S::Scalar>& term,
                         Closure<S>& closure) {
  for (const auto& [column, ratio] : tree.coordinate_expressions[term.index].terms) {
    std::size_t node = 1;
    while (tree.nodes[node].column != column) ++node;
    closure.path.push_back({static_cast<int>(node), 1, static_cast<int>(closure.terms.size())});
    VelocityTerm<S> rate;
    rate.factor = term.factor * ratio;
    closure.terms.push_back(rate);
    grow_row_scale(rate.factor, tree.is_length_column[column] ? tree.characteristic_length : 1, closure);
  }
}

template <class S>
void add_frame_component(const Tree<S>& tree, const GeneralisedSpeedTermOf<typename S::Scalar>& term,
                         Closure<S>& closure) {
  using Of = typename GeneralisedSpeedTermOf<typename S::Scalar>::Kind;
  const bool velocity = term.kind == Of::velocity || term.kind == Of::velocity_body;
  VelocityTerm<S> rate;
  rate.of = velocity ? VelocityTerm<S>::Of::velocity : VelocityTerm<S>::Of::angular_velocity;
  rate.is_in_body_axes = term.kind == Of::velocity_body || term.kind == Of::angular_velocity_body;
  rate.axis = term.index;
  rate.factor = term.factor;
  rate.frame = offset_frame<S>(tree.bodies[term.body], Matrix3Of<typename S::Scalar>::Identity(), term.position);
  for (int n = rate.frame.node; n > 0; n = tree.nodes[n].parent)
    if (tree.nodes[n].motion != NodeMotion::weld)
      closure.path.push_back({n, 1, static_cast<int>(closure.terms.size())});
  closure.terms.push_back(rate);
  grow_row_scale(rate.factor, velocity ? tree.characteristic_length : 1, closure);
}

}  // namespace

template <class S>
Closure<S> make_rolling_closure(const Tree<S>& tree, const JointOf<typename S::Scalar>& joint, int j) {
  const Matrix3Of<typename S::Scalar> axes = closure_axes<S>(joint);
  Closure<S> closure;
  closure.joint = j;
  closure.a = offset_frame<S>(tree.bodies[joint.first], axes, joint.point_first);
  closure.b = offset_frame<S>(tree.bodies[joint.second], joint.rotation.transpose() * axes, joint.point_second);
  closure.rows = {{ClosureRow::Kind::slip, 0, 0}, {ClosureRow::Kind::slip, 1, 0}};
  closure.contact = {joint.type == JointType::rolling_disc, joint.radius};
  return closure;
}

template <class S>
Closure<S> make_speed_closure(const Tree<S>& tree, const GeneralisedSpeedOf<typename S::Scalar>& constraint) {
  Closure<S> closure;
  closure.joint = -1;
  closure.rows = {{ClosureRow::Kind::sum, 0, 0}};
  for (const auto& term : constraint.terms)
    if (term.kind == GeneralisedSpeedTermOf<typename S::Scalar>::Kind::coordinate)
      add_coordinate_rate(tree, term, closure);
    else
      add_frame_component(tree, term, closure);
  return closure;
}

using OnPlane = PlanarOf<EngineScalar>;
using InSpace = SpatialOf<EngineScalar>;
template Closure<OnPlane> make_rolling_closure<OnPlane>(const Tree<OnPlane>&, const JointOf<EngineScalar>&, int);
template Closure<InSpace> make_rolling_closure<InSpace>(const Tree<InSpace>&, const JointOf<EngineScalar>&, int);
template Closure<OnPlane> make_speed_closure<OnPlane>(const Tree<OnPlane>&, const GeneralisedSpeedOf<EngineScalar>&);
template Closure<InSpace> make_speed_closure<InSpace>(const Tree<InSpace>&, const GeneralisedSpeedOf<EngineScalar>&);

}  // namespace balance
