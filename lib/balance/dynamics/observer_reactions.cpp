/// What the joints transmit.

#include "balance/dynamics/observer.hpp"

#include "balance/base/number.hpp"

namespace balance {

template <class S>
void Observer<S>::add_closure_wrenches(const std::vector<T>& multipliers) {
  int r = 0;
  for (const Closure<S>& closure : tree_.closures) {
    const ClosurePose<S> pose = closure_pose(*state_, closure);
    Wrench<S> on_b;  // world axes, about b's origin
    for (const ClosureRow& row : closure.rows) {
      const T multiplier = multipliers[r++];
      const RowWrench<S> unit = closure_wrench(pose, row);
      on_b.force += multiplier * unit.force;
      on_b.moment += multiplier * unit.moment;
    }
    if (!closure.split) {
      seen_.joint_force[closure.joint] = to_3d(on_b.force);
      seen_.joint_moment[closure.joint] = angular_to_3d(on_b.moment);
    }
    const auto push = [&](int n, double sign) {
      if (n == 0) return;
      const NodeState<S>& s = (*state_)[n];
      const typename S::Vector force = sign * unrotate(s.R_WN, on_b.force);
      wrenches_[n].force -= force;
      wrenches_[n].moment -=
          sign * unrotate(s.R_WN, on_b.moment) + cross(unrotate(s.R_WN, typename S::Vector(pose.p_B - s.p_WN)), force);
    };
    push(closure.b.node, 1);
    push(closure.a.node, -1);
  }
}

template <class S>
void Observer<S>::read_reactions(const Instant<S>& now, const std::vector<T>& multipliers) {
  State<S>& state = *state_;
  if (!tree_.closures.empty()) {
    for (auto& wrench : wrenches_) wrench = {};
    Wrench<S> total, loads;
    if (!external_.none()) external_.subtract(state, now.time, wrenches_, total, loads);
    add_closure_wrenches(multipliers);
    inverse_dynamics(tree_, state, wrenches_, tau_.data());
  }
  for (std::size_t j = 0; j < mechanism_.joints.size(); ++j) {
    const int n = tree_.joint_nodes[j];
    if (n < 0) continue;
    const FixedFrame<S>& second = tree_.bodies[mechanism_.joints[j].second];
    const typename S::Vector Q =
        state[second.node].p_WN +
        state[second.node].R_WN *
            typename S::Vector(second.p_N + second.R_N * to_vector<S>(mechanism_.joints[j].point_second));
    const typename S::Vector force = state[n].R_WN * wrenches_[n].force;
    const typename S::Angular moment =
        state[n].R_WN * wrenches_[n].moment + cross(typename S::Vector(state[n].p_WN - Q), force);
    const double sign = tree_.joint_forward[j] ? 1 : -1;
    seen_.joint_force[j] = to_3d(typename S::Vector(sign * force));
    seen_.joint_moment[j] = angular_to_3d(typename S::Angular(sign * moment));
  }
}

template void Observer<PlanarOf<Number>>::add_closure_wrenches(const std::vector<Number>&);
template void Observer<SpatialOf<Number>>::add_closure_wrenches(const std::vector<Number>&);
template void Observer<PlanarOf<Number>>::read_reactions(const Instant<PlanarOf<Number>>&, const std::vector<Number>&);
template void Observer<SpatialOf<Number>>::read_reactions(const Instant<SpatialOf<Number>>&,
                                                          const std::vector<Number>&);

}  // namespace balance
