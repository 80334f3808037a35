#pragma once
/// Inverse dynamics as a matrix times the inertial parameters of all mass elements (bodies, attachments, discs): forces are
/// linear in m, m r and the inertia about the element's frame. Private to dynamics and the rooms that open it up.

#include "balance/dynamics/recursion.hpp"

namespace balance {

/// Parameters of one inertia: planar m, mx, my, J; spatial m, mx, my, mz, Ixx, Iyy, Izz, Ixy, Ixz, Iyz.
template <class S>
VectorX parameters_of(const typename S::Inertia& inertia);
template <>
VectorX parameters_of<Planar>(const Planar::Inertia& inertia);
template <>
VectorX parameters_of<Spatial>(const Spatial::Inertia& inertia);

/// All elements' parameters, one after another, each about its own frame's origin.
template <class S>
VectorX parameters_of(const Tree<S>& tree);

template <class S>
struct Regressor {
  MatrixX torque;  ///< columns × P: generalised forces of the tree per unit parameter
  MatrixX force;   ///< dimension × P: rate of linear momentum less weight, world axes
  MatrixX moment;  ///< angular × P: the same about the world's origin
};

/// @param state poses, velocities and accelerations; with the ground accelerated by −g weight is included
template <class S>
Regressor<S> regressor(const Tree<S>& tree, const State<S>& state);

/// Its force and moment alone, without going through the joints: a cost that grows as the mechanism does.
template <class S>
Regressor<S> ground_regressor(const Tree<S>& tree, const State<S>& state);

#define BALANCE_DECLARE(S)                                                           \
  extern template VectorX parameters_of<S>(const Tree<S>&);                          \
  extern template Regressor<S> ground_regressor<S>(const Tree<S>&, const State<S>&); \
  extern template Regressor<S> regressor<S>(const Tree<S>&, const State<S>&);
BALANCE_DECLARE(Planar)
BALANCE_DECLARE(Spatial)
#undef BALANCE_DECLARE

}  // namespace balance
