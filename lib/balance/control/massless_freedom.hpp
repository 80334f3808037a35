#pragma once
/// Freedoms that no mass resists: bodies without mass or without extent may leave the mass matrix singular. Private to control.

#include "balance/control/loop_dynamics.hpp"

namespace balance {

/// @param loops assembled and closed; on return prepared and transformed
/// @return done, or which coordinate moves without mass and which body has none
template <class S>
MotionOutcome check_mass_matrix(const Mechanism& mechanism, LoopDynamics<S>& loops, double time, const double* dy);

}  // namespace balance
