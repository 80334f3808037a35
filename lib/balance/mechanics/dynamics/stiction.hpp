#pragma once
/// Decides which joints with dry friction stay at rest, and in which direction the others slip: Coulomb's law as a
/// set-valued force.

#include "balance/foundation/base/types.hpp"
#include "balance/mechanics/kinematics/tree.hpp"
#include "balance/mechanics/model/friction_law.hpp"

#include <vector>

namespace balance::dynamics {

/// A joint with friction while the mechanism moves.
struct JointFriction {
  Friction law;
  kinematics::LinearQuantity coordinate;
  double unit;                  ///< 1 or the characteristic length
  double regularisation_speed;  ///< half of the range over which the smoothed law changes its sign; 0: the exact law
  int slip_direction = 0, last_sign = 0;  ///< present slip direction, and that before the last decision
  bool is_sticking = false;
  double rate_tolerance = 0;  ///< rate of the wrong sign that counts as round-off, in units
  double friction = 0;        ///< friction force while it sticks

  bool has_dry_friction() const { return law.static_limit(1) > 0 || law.static_limit(-1) > 0; }
  double rate(const double* dy) const { return coordinate.rate(dy); }
  // for joints that may stick, whose coordinate is not a sum
  int column() const { return coordinate.terms[0].first; }
  double ratio() const { return coordinate.terms[0].second; }
};

/// What a decision about dry friction has changed.
enum class FrictionChange {
  none,
  slip_direction,  ///< the slip direction of some joint
  sticking_set,    ///< which joints stick
};

/// Largest magnitudes of friction against forward (λ > 0) and backward (λ < 0) motion; not negative.
struct FrictionLimits {
  VectorX forward, backward;
};

/// Joints at rest at this instant. Their accelerations are w = free_acceleration − response · λ, where λ is their
/// friction. Entries are in each joint's own units (rad or m, N m or N).
struct StickProblem {
  MatrixX response;  ///< m×m, G M⁻¹ Gᵀ: symmetric positive semidefinite; singular if the joints depend on each other
  VectorX free_acceleration;       ///< w without friction in these joints
  VectorX acceleration_tolerance;  ///< accelerations up to this size count as zero
  FrictionLimits static_limit;     ///< while the joint rests; at least one of both is positive
  FrictionLimits sliding_limit;    ///< once it slips; at most static_limit
};

struct StickSolution {
  std::vector<int> slip_direction;  ///< per joint: 0 if it stays at rest, else the sign of its acceleration
  VectorX friction;                 ///< λ
  /// Margin to the nearest change. If positive, the reserve of the most loaded joint as a fraction of its larger limit;
  /// otherwise minus the largest acceleration, relative to the terms of w.
  double margin = 1;
};

/// Accelerations by the principle of least constraint: they minimise Gauss' function plus Σ limit |w|, a convex problem
/// whose solution is unique even if λ is not. Once a joint breaks loose, its sliding friction becomes its limit, and
/// the problem is solved again.
StickSolution solve_stick_slip(const StickProblem& problem);

}  // namespace balance::dynamics
