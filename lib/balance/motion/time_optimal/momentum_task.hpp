#pragma once
/// Solves for motions of remaining quantities that give the angular momentum its prescribed values.

#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

namespace balance::time_optimal {

/// Fills the solutions of the trajectory's momentum tasks. If the rest of the drive moves at the rates q'₀ and the
/// quantities φ at the rates φ', the prescribed components of the angular momentum are h₀ + J φ'. This is an ordinary
/// differential equation for φ, over the path parameter if the components stay zero and over time otherwise. It is
/// solved by collocation at Chebyshev points. Derivation: docs/motion.md.
/// @return done; or why not: J loses rank, the path cannot be followed, or the prescribed values do not cover the
///        motion
/// @throws std::invalid_argument if quantities and components do not match, or if time matters and the law is not known
///        yet. The message is suitable for users.
MotionOutcome solve_momentum_tasks(const Mechanism& mechanism, Trajectory& trajectory);

}  // namespace balance::time_optimal
