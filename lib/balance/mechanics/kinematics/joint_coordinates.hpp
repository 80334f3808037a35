#pragma once
/// Coordinates of joints outside the tree, computed from the relative motion of the two bodies.

#include "balance/mechanics/kinematics/forward_kinematics.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

namespace balance::kinematics {

/// Up to six coordinates of one joint with their derivatives.
template <class T>
struct JointMotion {
  std::array<T, 6> position{}, velocity{}, acceleration{};
};

/// Motion of a joint's second body seen by an observer on its first, in the first body's axes.
template <class T>
struct RelativeMotion {
  Matrix3Of<T> rotation;      ///< of the second body's frame, without the joint's own constant rotation
  Vector3Of<T> displacement;  ///< from the joint's point on the first body to that on the second
  Vector3Of<T> linear_velocity, linear_acceleration;  ///< its first and second derivative
  Vector3Of<T> angular_velocity, angular_acceleration;
};

/// @param state poses; for the rates also velocities and accelerations
template <class S>
RelativeMotion<typename S::Scalar> relative_motion(const Tree<S>& tree, const TreeState<S>& state,
                                                   const model::JointOf<typename S::Scalar>& joint);

/// Angles in (−π, π]. Rates of a spherical joint are infinite at a second angle of ±π/2.
template <class T>
JointMotion<T> compute_joint_motion(const model::JointOf<T>& joint, const RelativeMotion<T>& motion);

/// The value that differs from `angle` by full turns and is nearest to `reference`.
template <class T>
T unwrap_angle(const T& angle, double reference) {
  constexpr double two_pi = 2 * std::numbers::pi;
  return angle + two_pi * std::round((reference - value_of(angle)) / two_pi);
}

/// All coordinates of the mechanism at y, cut joints and floating spherical ones included, angles in (−π, π].
template <class S>
std::vector<double> compute_coordinates(const Mechanism& mechanism, const Tree<S>& tree, const VectorX& y);

extern template std::vector<double> compute_coordinates<Planar>(const Mechanism&, const Tree<Planar>&, const VectorX&);
extern template std::vector<double> compute_coordinates<Spatial>(const Mechanism&, const Tree<Spatial>&,
                                                                 const VectorX&);

// Conversion between the mechanism's joint coordinates and the tree's coordinates.

/// Tree coordinates and rates that correspond to the joint coordinates. Non-finite results count as zero.
/// @param tree with the spherical joints' reference orientations as compiled
/// @param q, dq per mechanism coordinate; those of cut joints are ignored
template <class S>
void to_tree_coordinates(const Mechanism& mechanism, const Tree<S>& tree, const VectorX& q, const VectorX& dq,
                         VectorX& y, VectorX& dy);

/// All joint coordinates with their derivatives, angles of cut and floating joints in (−π, π].
/// @param state poses, velocities, accelerations
template <class S>
void to_joint_coordinates(const Mechanism& mechanism, const Tree<S>& tree, const TreeState<S>& state, const double* y,
                          const double* dy, const double* ddy, VectorX& q, VectorX& dq, VectorX& ddq);

/// Per tree column: the mechanism coordinate that equals it, else one that is a multiple of it; −1 if there is none.
template <class S>
std::vector<CoordinateId> find_column_coordinates(const Tree<S>& tree) {
  std::vector<CoordinateId> out(tree.columns, -1);
  for (std::size_t c = tree.coordinate_expressions.size(); c-- > 0;) {
    const LinearQuantity& source = tree.coordinate_expressions[c];
    if (!source.has_single_term()) continue;
    CoordinateId& leader = out[source.terms[0].first];
    if (leader < 0 || source.is_column()) leader = static_cast<int>(c);
  }
  return out;
}

/// Converts a spherical joint's rates to another reference orientation, preserving the relative angular velocity.
/// @param before, y before reset_spherical_reference() @param after, y_after after it
template <class S>
void transfer_spherical_rates(const Tree<S>& before, const double* y, const Tree<S>& after, const double* y_after,
                              NodeId spherical, double* dy);

/// "J1 0.3, J2 -1.2, …": the first dozen coordinates.
std::string format_configuration(const Mechanism& mechanism, const VectorX& q);

#define BALANCE_DECLARE(S)                                                                                           \
  extern template void to_tree_coordinates<S>(const Mechanism&, const Tree<S>&, const VectorX&, const VectorX&,      \
                                              VectorX&, VectorX&);                                                   \
  extern template void to_joint_coordinates<S>(const Mechanism&, const Tree<S>&, const TreeState<S>&, const double*, \
                                               const double*, const double*, VectorX&, VectorX&, VectorX&);          \
  extern template void transfer_spherical_rates<S>(const Tree<S>&, const double*, const Tree<S>&, const double*,     \
                                                   NodeId, double*);
BALANCE_DECLARE(Planar)
BALANCE_DECLARE(Spatial)
#undef BALANCE_DECLARE

}  // namespace balance::kinematics
