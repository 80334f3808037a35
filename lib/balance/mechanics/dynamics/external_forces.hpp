#pragma once
/// What the surroundings and springs do to the bodies.

#include "balance/mechanics/dynamics/tree_dynamics.hpp"
#include "balance/mechanics/kinematics/tree.hpp"
#include "balance/mechanics/model/friction_law.hpp"
#include "balance/mechanics/model/mechanism.hpp"

#include <algorithm>

namespace balance {

/// Magnitudes of the terms of a force and of its moment about a node's origin, added up.
struct ForceMagnitude {
  double force = 0, moment = 0;
};

template <class S>
class ExternalForces {
 public:
  using Scalar = typename S::Scalar;

  ExternalForces(const MechanismOf<Scalar>& mechanism, const Tree<S>& tree);

  bool is_empty() const { return loads_.empty() && springs_.empty() && joint_springs_.empty(); }

  /// Subtracts every external wrench from its node's entry and sums them up. Springs in joint coordinates are no wrenches here but,
  /// like motors and friction, part of what a joint transmits.
  /// @param state poses in the world
  /// @param total what loads and springs together do to the moving bodies: world axes, about the world's origin
  /// @param loads the loads' part of it
  void subtract(const TreeState<S>& state, const Scalar& time, std::vector<Wrench<S>>& wrenches, Wrench<S>& total,
                Wrench<S>& loads) const;

  /// Adds what springs in joint coordinates ask of the tree's coordinates: stiffness · q − preload.
  /// @param y tree coordinates @param tau per tree coordinate [N m or N]
  void add_joint_springs(const Scalar* y, Scalar* tau) const;

  /// Energy stored in the springs, in those in joints from coordinate zero on [J].
  Scalar energy(const TreeState<S>& state, const Scalar* y) const;

  /// Adds to every node's entry how large the terms of its external wrenches are: a spring's tension is a difference of lengths,
  /// which are differences of places.
  void add_magnitudes(const TreeState<S>& state, const Scalar& time, std::vector<ForceMagnitude>& sizes) const;
  /// Magnitudes of all external wrenches, about the world's origin: what is left of where the same wrenches are added and subtracted.
  ForceMagnitude sum_magnitudes(const TreeState<S>& state, const Scalar& time) const;
  /// The same as add_magnitudes() of add_joint_springs(), per tree coordinate.
  void add_joint_magnitudes(const Scalar* y, std::vector<double>& tau) const;
  /// The same of the springs' energy [J].
  double energy_magnitude(const TreeState<S>& state, const Scalar* y) const;

 private:
  struct PlacedLoad {
    const LoadOf<Scalar>* load;
    FixedFrame<S> frame;  ///< origin where it acts, axes of the body
  };
  struct PlacedSpring {
    FixedFrame<S> first, second;
    Scalar stiffness, free_length;
  };
  struct JointSpring {
    const LinearQuantityOf<Scalar>* coordinate;
    Scalar stiffness, preload;

    /// How large the coordinate is; a turn of one radian at least, which rounds like one.
    double coordinate_magnitude(const Scalar* y) const;
  };

  /// Calls add(frame, force, moment) with the magnitudes of every wrench on a body that moves.
  /// @param tension of a spring, per unit of its stiffness
  template <class Tension, class Add>
  void visit_magnitudes(const Scalar& time, const Tension& tension, const Add& add) const;
  static double length_magnitude(const TreeState<S>& state, const PlacedSpring& spring);
  void apply(const TreeState<S>& state, const FixedFrame<S>& at, const typename S::Vector& force,
             typename S::Angular moment, std::vector<Wrench<S>>& wrenches, Wrench<S>& total) const;

  std::vector<PlacedLoad> loads_;
  std::vector<PlacedSpring> springs_;
  std::vector<JointSpring> joint_springs_;
};

extern template class ExternalForces<Planar>;
extern template class ExternalForces<Spatial>;

// Joint friction of a tree in motion.

/// Adds what friction takes to the generalised forces; coordinates at rest count as frictionless (docs/theory.md, section 3).
/// @param dy rates of the tree's coordinates @param duration of the whole motion [s]
/// @param tau per tree coordinate [N m or N]
template <class S>
void add_friction_forces(const MechanismOf<typename S::Scalar>& mechanism, const Tree<S>& tree,
                         const typename S::Scalar* dy, double duration, typename S::Scalar* tau) {
  using T = typename S::Scalar;
  double fastest = 0;
  for (int c = 0; c < tree.columns; ++c)
    fastest =
        std::max(fastest, std::abs(value_of(dy[c])) / (tree.is_length_column[c] ? tree.characteristic_length : 1));
  const double rest = rest_rate_threshold(fastest, duration);
  for (const FrictionOf<T>& friction : mechanism.friction) {
    const LinearQuantityOf<T>& source = tree.coordinate_expressions[friction.coordinate];
    const bool slides = mechanism.coordinates[friction.coordinate].kind == CoordinateKind::length;
    const T rate = source.rate(dy);
    const int sign = sliding_sign(value_of(rate), slides ? rest * tree.characteristic_length : rest);
    source.add_generalised_force(sliding_friction(friction, rate, sign), tau);
  }
}

}  // namespace balance
