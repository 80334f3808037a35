#include "balance/kinematics/rate_closures.hpp"

#include "balance/base/number.hpp"
#include "balance/kinematics/joint_steps.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

namespace {

template <class S>
void grow(const typename S::Scalar& factor, double size, Closure<S>& closure) {
  const double most = std::abs(value_of(factor)) * size;
  closure.unit = closure.terms.size() == 1 ? most : std::max(closure.unit, most);
}

/// As many terms as columns that the coordinate follows.
template <class S>
void add_rates(const Tree<S>& tree, const SpeedTermOf<typename S::Scalar>& term, Closure<S>& closure) {
  for (const auto& [column, ratio] : tree.sources[term.index].terms) {
    std::size_t node = 1;
    while (tree.nodes[node].column != column) ++node;
    closure.path.push_back({static_cast<int>(node), 1, static_cast<int>(closure.terms.size())});
    RateTerm<S> rate;
    rate.factor = term.factor * ratio;
    closure.terms.push_back(rate);
    grow(rate.factor, tree.column_kind_length[column] ? tree.length : 1, closure);
  }
}

template <class S>
void add_component(const Tree<S>& tree, const SpeedTermOf<typename S::Scalar>& term, Closure<S>& closure) {
  using Of = typename SpeedTermOf<typename S::Scalar>::Of;
  const bool velocity = term.of == Of::velocity || term.of == Of::velocity_own;
  RateTerm<S> rate;
  rate.of = velocity ? RateTerm<S>::Of::velocity : RateTerm<S>::Of::turning;
  rate.own = term.of == Of::velocity_own || term.of == Of::turning_own;
  rate.axis = term.index;
  rate.factor = term.factor;
  rate.frame = fixed_on<S>(tree.bodies[term.body], Matrix3Of<typename S::Scalar>::Identity(), term.position);
  for (int n = rate.frame.node; n > 0; n = tree.nodes[n].parent)
    if (tree.nodes[n].motion != NodeMotion::weld)
      closure.path.push_back({n, 1, static_cast<int>(closure.terms.size())});
  closure.terms.push_back(rate);
  grow(rate.factor, velocity ? tree.length : 1, closure);
}

}  // namespace

template <class S>
Closure<S> rolling_closure(const Tree<S>& tree, const JointOf<typename S::Scalar>& joint, int j) {
  const Matrix3Of<typename S::Scalar> axes = closure_axes<S>(joint);
  Closure<S> closure;
  closure.joint = j;
  closure.a = fixed_on<S>(tree.bodies[joint.first], axes, joint.point_first);
  closure.b = fixed_on<S>(tree.bodies[joint.second], joint.rotation.transpose() * axes, joint.point_second);
  closure.rows = {{ClosureRow::Kind::slip, 0, 0}, {ClosureRow::Kind::slip, 1, 0}};
  closure.contact = {joint.type == JointType::rolling_disc, joint.radius};
  return closure;
}

template <class S>
Closure<S> constraint_closure(const Tree<S>& tree, const SpeedOf<typename S::Scalar>& constraint) {
  Closure<S> closure;
  closure.joint = -1;
  closure.rows = {{ClosureRow::Kind::sum, 0, 0}};
  for (const auto& term : constraint.terms)
    if (term.of == SpeedTermOf<typename S::Scalar>::Of::coordinate)
      add_rates(tree, term, closure);
    else
      add_component(tree, term, closure);
  return closure;
}

using OnPlane = PlanarOf<Number>;
using InSpace = SpatialOf<Number>;
template Closure<OnPlane> rolling_closure<OnPlane>(const Tree<OnPlane>&, const JointOf<Number>&, int);
template Closure<InSpace> rolling_closure<InSpace>(const Tree<InSpace>&, const JointOf<Number>&, int);
template Closure<OnPlane> constraint_closure<OnPlane>(const Tree<OnPlane>&, const SpeedOf<Number>&);
template Closure<InSpace> constraint_closure<InSpace>(const Tree<InSpace>&, const SpeedOf<Number>&);

}  // namespace balance
