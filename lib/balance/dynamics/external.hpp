#pragma once
/// What the surroundings and springs do to the bodies. Private to dynamics and the rooms that open it up.

#include "balance/dynamics/recursion.hpp"
#include "balance/model/mechanism.hpp"

namespace balance {

template <class S>
class ExternalForces {
 public:
  ExternalForces(const Mechanism& mechanism, const Tree<S>& tree);

  bool none() const { return loads_.empty() && springs_.empty(); }

  /// Subtracts every external wrench from its node's entry and sums them up.
  /// @param state poses in the world
  /// @param total what loads and springs together do to the moving bodies: world axes, about the world's origin
  /// @param loads the loads' part of it
  void subtract(const State<S>& state, double time, std::vector<Wrench<S>>& wrenches, Wrench<S>& total,
                Wrench<S>& loads) const;

  /// Energy stored in the springs [J].
  double energy(const State<S>& state) const;

 private:
  struct PlacedLoad {
    const Load* load;
    FixedFrame<S> frame;  ///< origin where it acts, axes of the body
  };
  struct PlacedSpring {
    FixedFrame<S> first, second;
    double stiffness, free_length;
  };

  void apply(const State<S>& state, const FixedFrame<S>& at, const typename S::Vector& force,
             typename S::Angular moment, std::vector<Wrench<S>>& wrenches, Wrench<S>& total) const;

  std::vector<PlacedLoad> loads_;
  std::vector<PlacedSpring> springs_;
};

extern template class ExternalForces<Planar>;
extern template class ExternalForces<Spatial>;

}  // namespace balance
