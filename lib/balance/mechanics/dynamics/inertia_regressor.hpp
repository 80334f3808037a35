#pragma once
/// Inverse dynamics as a matrix times the inertial parameters of all mass elements (bodies, attachments, discs): forces
/// are linear in m, m r and the inertia about the origin of the element's frame.

#include "balance/mechanics/dynamics/tree_dynamics.hpp"

namespace balance::dynamics {

/// Parameters of one inertia: planar m, mx, my, J; spatial m, mx, my, mz, Ixx, Iyy, Izz, Ixy, Ixz, Iyz.
template <class S>
VectorX list_inertial_parameters(const typename S::Inertia& inertia);
template <>
VectorX list_inertial_parameters<kinematics::Planar>(const kinematics::Planar::Inertia& inertia);
template <>
VectorX list_inertial_parameters<kinematics::Spatial>(const kinematics::Spatial::Inertia& inertia);

/// All elements' parameters, one after another, each about its own frame's origin.
template <class S>
VectorX list_inertial_parameters(const kinematics::Tree<S>& tree);

template <class S>
struct InertiaRegressor {
  MatrixX torque;  ///< columns × P: generalised forces of the tree per unit parameter
  MatrixX force;   ///< dimension × P: rate of linear momentum minus weight, world axes
  MatrixX moment;  ///< angular × P: the same about the world's origin
};

/// @param state poses, velocities and accelerations; with the ground accelerated by −g weight is included
template <class S>
InertiaRegressor<S> compute_regressor(const kinematics::Tree<S>& tree, const kinematics::TreeState<S>& state);

/// One for each inertial parameter.
template <class S>
using UnitWrenches = std::vector<Wrench<S>>;

/// The wrench that gives an element of unit parameter its motion, for every inertial parameter: in the axes of the
/// element's node, about its origin. Parameters of elements on the ground have none.
template <class S>
UnitWrenches<S> compute_unit_wrenches(const kinematics::Tree<S>& tree, const kinematics::TreeState<S>& state);

/// Only its force and moment, without visiting the joints: the cost is linear in the size of the mechanism.
template <class S>
InertiaRegressor<S> compute_momentum_rate_regressor(const kinematics::Tree<S>& tree,
                                                    const kinematics::TreeState<S>& state);

#define BALANCE_DECLARE(S)                                                                                 \
  extern template VectorX list_inertial_parameters<S>(const kinematics::Tree<S>&);                         \
  extern template UnitWrenches<S> compute_unit_wrenches<S>(const kinematics::Tree<S>&,                     \
                                                           const kinematics::TreeState<S>&);               \
  extern template InertiaRegressor<S> compute_momentum_rate_regressor<S>(const kinematics::Tree<S>&,       \
                                                                         const kinematics::TreeState<S>&); \
  extern template InertiaRegressor<S> compute_regressor<S>(const kinematics::Tree<S>&, const kinematics::TreeState<S>&);
BALANCE_DECLARE(kinematics::Planar)
BALANCE_DECLARE(kinematics::Spatial)
#undef BALANCE_DECLARE

}  // namespace balance::dynamics
