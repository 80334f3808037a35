#pragma once
/// Which joints with dry friction stay at rest, and which way the others slip: Coulomb's law as a set-valued force. Private to
/// control.

#include "balance/base/types.hpp"

#include <vector>

namespace balance {

/// Magnitudes of what friction can resist with, against motions forwards (λ > 0) and backwards (λ < 0); not negative.
struct FrictionLimits {
  VectorX forward, backward;
};

/// Joints that stand still at this moment. Their accelerations are w = free − response · λ, λ being what friction resists with.
/// Entries are in each joint's own units (rad or m, N m or N).
struct StickProblem {
  MatrixX response;  ///< m×m, G M⁻¹ Gᵀ: symmetric, not negative; singular where the joints depend on each other
  VectorX free_acceleration;       ///< w without friction in these joints
  VectorX acceleration_tolerance;  ///< accelerations up to this size are none
  FrictionLimits static_limit;     ///< while the joint rests; one of both positive
  FrictionLimits sliding_limit;    ///< once it slips, at most at_rest
};

struct StickSolution {
  std::vector<int> slip_direction;  ///< per joint: 0 it stays, else the sign of its acceleration
  VectorX friction;                 ///< λ
  /// How far the nearest change is: positive, the part of its larger limit that the most loaded joint has left; else all that is
  /// beyond, with a negative sign, as a part of the terms that w is made of.
  double margin = 1;
};

/// The accelerations of least constraint: those that make Gauss' function plus Σ limit |w| least, a convex problem whose
/// solution is unique, also where λ is not. A joint that breaks loose resists with its sliding friction from then on, and the
/// question is asked again.
StickSolution solve_stick_slip(const StickProblem& problem);

}  // namespace balance
