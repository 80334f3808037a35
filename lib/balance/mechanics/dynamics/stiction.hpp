#pragma once
/// Which joints with dry friction stay at rest, and which way the others slip: Coulomb's law as a set-valued force.

#include "balance/foundation/base/types.hpp"
#include "balance/mechanics/kinematics/tree.hpp"
#include "balance/mechanics/model/friction_law.hpp"

#include <vector>

namespace balance {

/// A joint with friction while the mechanism moves.
struct JointFriction {
  Friction law;
  LinearQuantity coordinate;
  double unit;  ///< 1 or the characteristic length
  double
      regularisation_speed;  ///< over which the smoothed law goes from its dry friction backwards to that forwards, half of it; 0: the true law
  int slip_direction = 0, last_sign = 0;  ///< the way it slips, and that before the last decision
  bool is_sticking = false;
  double rate_tolerance = 0;  ///< rate of the wrong sign that is round-off, in units
  double friction = 0;        ///< what it resists with while it sticks

  bool has_dry_friction() const { return law.static_limit(1) > 0 || law.static_limit(-1) > 0; }
  double rate(const double* dy) const { return coordinate.rate(dy); }
  // of a joint that may stick, which follows no sum
  int column() const { return coordinate.terms[0].first; }
  double ratio() const { return coordinate.terms[0].second; }
};

/// What a decision about dry friction has changed.
enum class FrictionChange {
  none,
  slip_direction,  ///< the way a joint slips
  sticking_set,    ///< which joints stick
};

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
