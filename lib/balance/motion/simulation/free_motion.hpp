#pragma once
/// Partly driven mechanisms: some coordinates follow the trajectory, others move by the mechanism's dynamics.
///
/// With the free coordinates f, the prescribed ones p (driven or held) and the efforts u of their actuators, the
/// equation of motion M q̈ + h = S u in the coordinates (f, p) is a linear system for f̈ and u:
///
///     M_f f̈ − S u = −h − M_p p̈
///
/// f̈ is integrated twice as a Chebyshev series on panels (Picard iteration at their points), which are as short as the
/// series need to converge to round-off.

#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

namespace balance::simulation {

/// A partly driven motion as one that is prescribed.
struct SolvedFreeMotion {
  MotionOutcome outcome;  ///< its notes name prescribed coordinates that have got an actuator
  /// With an actuator for every prescribed coordinate that needs one, then for every free coordinate. The efforts of the
  /// latter are zero but for the accuracy of the solution.
  Mechanism mechanism;
  Trajectory trajectory;  ///< Trajectory::courses has the solution
};

/// @param trajectory with a free motion
/// @return unreachable if the motion cannot be followed, or if there is no equilibrium or periodic motion;
///         mismatch if coordinates are neither driven, held nor free, or efforts are not determined
/// @throws std::invalid_argument if something in the mechanism or the trajectory does not go with free coordinates. The
///         message is suitable for users.
SolvedFreeMotion solve_free_motion(const Mechanism& mechanism, const Trajectory& trajectory);

}  // namespace balance::simulation
