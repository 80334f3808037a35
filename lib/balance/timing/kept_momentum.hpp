#pragma once
/// Finds how remaining quantities must go for the angular momentum to stay zero. Private to timing.

#include "balance/motion/motion.hpp"
#include "balance/motion/trajectory.hpp"

namespace balance {

/// Fills the trajectory's courses of kept momentum. Where the rest of the drive goes at the rates q'₀ along the way and the quantities
/// φ at the rates φ', the angular momentum is h₀ + J φ' = 0: an ordinary differential equation for φ over the way, the same for every
/// law. It is solved by collocation at Chebyshev's points. Derivation: docs/motion.md.
/// @return done; or why not: J loses its rank somewhere, or the way there cannot be followed
/// @throws std::invalid_argument if there are not as many such quantities as the angular momentum has components
MotionOutcome keep_momentum(const Mechanism& mechanism, Trajectory& trajectory);

}  // namespace balance
