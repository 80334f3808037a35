#pragma once
/// Loads, springs and dampers that act on the bodies.

#include "balance/mechanics/dynamics/tree_dynamics.hpp"
#include "balance/mechanics/kinematics/tree.hpp"
#include "balance/mechanics/model/friction_law.hpp"
#include "balance/mechanics/model/load_table.hpp"
#include "balance/mechanics/model/mechanism.hpp"

#include <algorithm>

namespace balance::dynamics {

/// Sums of the magnitudes of the terms of a force, and of its moment about a node's origin.
struct ForceMagnitude {
  double force = 0, moment = 0;
};

template <class S>
class ExternalForces {
 public:
  using Scalar = typename S::Scalar;

  ExternalForces(const MechanismOf<Scalar>& mechanism, const kinematics::Tree<S>& tree);

  bool is_empty() const {
    return loads_.empty() && springs_.empty() && joint_springs_.empty() && point_elements_.empty() &&
           joint_tables_.empty();
  }
  /// Whether some force depends on rates.
  bool has_dampers() const { return has_dampers_; }

  /// Subtracts every external wrench from its node's entry and sums them up. Springs in joint coordinates are not among
  /// them: like motors and friction, they are part of the joint's reaction.
  /// @param state poses in the world; with dampers also velocities (compute_origin_velocities)
  /// @param y tree coordinates, for loads over a coordinate
  /// @param total of loads, springs and dampers on the moving bodies: world axes, about the world's origin
  /// @param loads part of it that is due to the loads
  void subtract(const kinematics::TreeState<S>& state, const Scalar* y, const Scalar& time,
                std::vector<Wrench<S>>& wrenches, Wrench<S>& total, Wrench<S>& loads) const;

  /// Adds the generalised forces that balance springs in joint coordinates: stiffness · q − preload, or minus a table's
  /// effort.
  /// @param y tree coordinates @param tau per tree coordinate [N m or N]
  void add_joint_springs(const Scalar* y, Scalar* tau) const;

  /// Energy stored in the springs [J]; that of joint springs is zero at coordinate zero, that of springs with a table at
  /// the first row.
  Scalar energy(const kinematics::TreeState<S>& state, const Scalar* y) const;

  /// Power that the dampers take, not negative [W]. @param state poses and velocities
  Scalar damper_power(const kinematics::TreeState<S>& state) const;

  /// Adds the magnitudes of the terms of its external wrenches to every node's entry. A spring's tension is a
  /// difference of lengths, which are differences of positions.
  void add_magnitudes(const kinematics::TreeState<S>& state, const Scalar* y, const Scalar& time,
                      std::vector<ForceMagnitude>& magnitudes) const;
  /// Magnitudes of all external wrenches about the world's origin, for sums in which the same wrenches are added and
  /// subtracted.
  ForceMagnitude sum_magnitudes(const kinematics::TreeState<S>& state, const Scalar* y, const Scalar& time) const;
  /// As add_magnitudes(), for add_joint_springs(), per tree coordinate.
  void add_joint_magnitudes(const Scalar* y, std::vector<double>& tau) const;
  /// The same for the springs' energy [J].
  double energy_magnitude(const kinematics::TreeState<S>& state, const Scalar* y) const;

 private:
  struct PlacedLoad {
    model::LoadTable<Scalar> table;
    const kinematics::LinearQuantityOf<Scalar>* coordinate;  ///< the table's argument; null: the time
    kinematics::FixedFrame<S> frame;                         ///< origin at the point of action, axes of the body

    /// Force and moment in the load's frame.
    void evaluate(const Scalar* y, const Scalar& time, Vector3Of<Scalar>& force, Vector3Of<Scalar>& moment) const {
      table.evaluate(coordinate != nullptr ? coordinate->value(y) : time, force, moment);
    }
  };
  struct PlacedSpring {
    model::SpringOf<Scalar> law;
    kinematics::FixedFrame<S> first, second;
  };
  struct JointSpring {
    const kinematics::LinearQuantityOf<Scalar>* coordinate;
    Scalar stiffness, preload;

    /// Magnitude of the coordinate; at least one radian for an angle, whose round-off is that of one radian.
    double coordinate_magnitude(const Scalar* y) const;
  };

  /// A damper, or a spring with a table, between points.
  struct PointElement {
    kinematics::FixedFrame<S> first, second;
    model::ForceLawOf<Scalar> law;  ///< unused by a damper
    Scalar damping;
    bool is_damper;
  };
  struct JointTable {
    const kinematics::LinearQuantityOf<Scalar>* coordinate;
    model::ForceLawOf<Scalar> law;
  };

  /// Calls add(frame, force, moment) with the magnitudes of every wrench on a moving body.
  /// @param tension of a spring, per unit of its stiffness
  template <class Tension, class Add>
  void visit_magnitudes(const kinematics::TreeState<S>& state, const Scalar* y, const Scalar& time,
                        const Tension& tension, const Add& add) const;
  template <class Ends>
  static double length_magnitude(const kinematics::TreeState<S>& state, const Ends& ends);
  static typename S::Vector end_velocity(const kinematics::TreeState<S>& state,
                                         const kinematics::FixedFrame<S>& frame) {
    return kinematics::point_velocity<S>(state[frame.node], frame.p_N);
  }
  /// Rate of the length times the length.
  static Scalar length_rate_product(const PointElement& element, const kinematics::TreeState<S>& state,
                                    const typename S::Vector& distance) {
    return distance.dot(end_velocity(state, element.second) - end_velocity(state, element.first));
  }
  void apply(const kinematics::TreeState<S>& state, const kinematics::FixedFrame<S>& frame,
             const typename S::Vector& force, typename S::Angular moment, std::vector<Wrench<S>>& wrenches,
             Wrench<S>& total) const;

  std::vector<PlacedLoad> loads_;
  std::vector<PlacedSpring> springs_;
  std::vector<JointSpring> joint_springs_;
  std::vector<PointElement> point_elements_;
  std::vector<JointTable> joint_tables_;
  bool has_dampers_ = false;
};

extern template class ExternalForces<kinematics::Planar>;
extern template class ExternalForces<kinematics::Spatial>;

// Joint friction of a tree in motion.

/// Adds the generalised forces that overcome friction; coordinates at rest count as frictionless (docs/theory.md,
/// section 3).
/// @param dy rates of the tree's coordinates @param duration of the whole motion [s]
/// @param tau per tree coordinate [N m or N]
template <class S>
void add_friction_forces(const MechanismOf<typename S::Scalar>& mechanism, const kinematics::Tree<S>& tree,
                         const typename S::Scalar* dy, double duration, typename S::Scalar* tau) {
  using T = typename S::Scalar;
  double max_rate = 0;
  for (int c = 0; c < tree.columns; ++c)
    max_rate =
        std::max(max_rate, std::abs(value_of(dy[c])) / (tree.is_length_column[c] ? tree.characteristic_length : 1));
  const double rest_threshold = model::rest_rate_threshold(max_rate, duration);
  for (const model::FrictionOf<T>& friction : mechanism.friction) {
    const kinematics::LinearQuantityOf<T>& source = tree.coordinate_expressions[friction.coordinate];
    const bool is_length = mechanism.coordinates[friction.coordinate].kind == CoordinateKind::length;
    const T rate = source.rate(dy);
    const int sign =
        model::sliding_sign(value_of(rate), is_length ? rest_threshold * tree.characteristic_length : rest_threshold);
    source.add_generalised_force(sliding_friction(friction, rate, sign), tau);
  }
}

}  // namespace balance::dynamics
