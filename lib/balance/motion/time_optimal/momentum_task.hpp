#pragma once
/// Finds how remaining quantities must go for the angular momentum to stay zero.

#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

namespace balance {

/// Fills the trajectory's courses of kept momentum. Where the rest of the drive goes at the rates q'₀ and the quantities φ at the
/// rates φ', the stated components of the angular momentum are h₀ + J φ': an ordinary differential equation for φ, over the way if
/// they stay zero and else over the time. It is solved by collocation at Chebyshev's points. Derivation: docs/motion.md.
/// @return done; or why not: J loses its rank somewhere, the way there cannot be followed, or the stated values end too early
/// @throws std::invalid_argument if quantities and components do not match, or if time decides and the law is not known yet. The
///         message is fit for a user.
MotionOutcome solve_momentum_tasks(const Mechanism& mechanism, Trajectory& trajectory);

}  // namespace balance
