#pragma once
/// What an Observer finds at a moment, with a moment in every lane. Private to lanes.

#include "balance/dynamics/readings.hpp"
#include "balance/lanes/actuation.hpp"
#include "balance/lanes/kernels.hpp"

#include <array>

namespace balance {

/// @tparam L the space S over packs
template <class L, class S>
class LaneSampleEvaluator {
 public:
  using T = typename L::Scalar;

  explicit LaneSampleEvaluator(const GroupSetup<S>& setup)
      : mechanism_(setup.mechanism),
        tree_(setup.tree),
        tool_(setup.drive.tool),
        gravity_(to_vector<S>(mechanism_.gravity).template cast<T>()),
        about_(setup.about.template cast<T>()),
        wrenches_(tree_.nodes.size()),
        tau_(static_cast<std::size_t>(tree_.columns)) {
    seen_.joint_force.assign(mechanism_.joints.size(), Vector3Of<T>::Zero());
    seen_.joint_moment = seen_.joint_force;
  }

  /// @param equations filled and actuation looked there, poses and angular velocities in the state
  void evaluate(const KinematicEquations<L>& equations, LaneActuation<L>& actuation, TreeState<L>& state, const T* dy,
                const T* ddy) {
    compute_origin_velocities(tree_, dy, state);
    compute_accelerations<L>(tree_, dy, ddy, -gravity_, state);
    for (auto& wrench : wrenches_) wrench = {};
    inverse_dynamics(tree_, state, wrenches_, tau_.data());
    actuation.solve(equations, tau_.data());
    efforts_ = actuation.efforts().data();
    const Wrench<L> none;
    compute_total_forces<L>(tree_, state, {wrenches_[0], none, none, gravity_, about_}, seen_);
    if (mechanism_.tool) {
      seen_.tool_position = to_3d(position(state, tool_));
      seen_.tool_rotation = to_matrix(orientation(state, tool_));
    }
    seen_.com_velocity = to_3d(com_velocity(tree_, state));
    compute_energies(tree_, state, gravity_, T(0.0), seen_);
    if (!tree_.closures.empty()) {
      for (auto& wrench : wrenches_) wrench = {};
      add_closure_wrenches(tree_, state, actuation.multipliers(), wrenches_, seen_);
      inverse_dynamics(tree_, state, wrenches_, tau_.data());
    }
    compute_joint_reactions(mechanism_, tree_, state, wrenches_, seen_);
  }

  /// The moments of all lanes, to the samples from `first` on.
  template <std::size_t N>
  void store(const T& mobility, int first, std::array<Sample, N>& samples) const {
    for (int l = 0; l < T::lanes; ++l) {
      Sample& out = samples[static_cast<std::size_t>(first) + static_cast<std::size_t>(l)];
      const auto copy = [l](const auto& in, auto& to) {
        for (Eigen::Index i = 0; i < in.size(); ++i) to.data()[i] = in.data()[i][l];
      };
      for (Eigen::Index a = 0; a < out.effort.size(); ++a) out.effort[a] = efforts_[a][l];
      copy(seen_.com, out.com);
      copy(seen_.com_velocity, out.com_velocity);
      copy(seen_.com_acceleration, out.com_acceleration);
      copy(seen_.tool_position, out.tool_position);
      copy(seen_.tool_rotation, out.tool_rotation);
      copy(seen_.shaking_force, out.shaking_force);
      copy(seen_.shaking_moment, out.shaking_moment);
      copy(seen_.ground_force, out.ground_force);
      copy(seen_.ground_moment, out.ground_moment);
      for (std::size_t j = 0; j < out.joint_force.size(); ++j) {
        copy(seen_.joint_force[j], out.joint_force[j]);
        copy(seen_.joint_moment[j], out.joint_moment[j]);
      }
      out.kinetic_energy = seen_.kinetic_energy[l];
      out.potential_energy = seen_.potential_energy[l];
      out.mobility = mobility[l];
    }
  }

 private:
  const Mechanism& mechanism_;
  const Tree<S>& tree_;
  const FixedFrame<S>& tool_;
  typename L::Vector gravity_, about_;
  std::vector<Wrench<L>> wrenches_;
  std::vector<T> tau_;
  const T* efforts_ = nullptr;  ///< per actuator
  SampleOf<T> seen_;
};

}  // namespace balance
