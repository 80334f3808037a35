#pragma once
/// Laws of motion s(τ): [0,1] → [0,1] with s(0) = 0, s(1) = 1 and their derivatives with respect to τ.

#include <vector>

namespace balance::trajectory {

enum class MotionLawKind {
  cycloidal,  ///< P3 eq. 52
  bang_bang,  ///< constant acceleration, then the opposite one
  uniform,    ///< constant velocity
  cubic,      ///< 3τ² − 2τ³
  polynomial_345,
  polynomial_4567,
  harmonic,  ///< simple harmonic, (1 − cos πτ)/2
  modified_sine,
  modified_trapezoidal,
  trapezoidal_velocity,  ///< ramps of given length with constant velocity between them
  time_optimal,          ///< minimum duration under given limits; found by motion/time_optimal, then a table
  min_peak,              ///< minimum peak of a quantity for a given duration; found likewise
  constant_momentum,     ///< constant angular momentum; found likewise
};

/// A node of an optimised law, with the limits of its second derivative on both sides.
struct MotionLawNode {
  double tau = 0, s = 0, ds = 0, dds_before = 0, dds_after = 0;
};

template <class T>
struct MotionLawOf {
  MotionLawKind kind = MotionLawKind::cycloidal;
  T ramp_up = 0.25;    ///< trapezoidal velocity: fraction of the duration spent accelerating, in (0, 1)
  T ramp_down = 0.25;  ///< … and decelerating; ramp_up + ramp_down ≤ 1
  /// Optimised laws: nodes from τ = 0 to 1, joined by quintics; empty: not found yet.
  std::vector<MotionLawNode> nodes;
};

using MotionLaw = MotionLawOf<double>;

/// s, s' and s'' at a time.
struct PhasePoint {
  double t = 0, s = 0, v = 0, u = 0;
};

/// Quintic Hermite interpolation between two points. If their s differ by round-off only, the quartic that matches all
/// values but the second s.
PhasePoint interpolate_quintic(const PhasePoint& a, const PhasePoint& b, double t);

/// Whether a law depends on the mechanism.
inline bool is_mechanism_dependent(MotionLawKind kind) {
  return kind == MotionLawKind::time_optimal || kind == MotionLawKind::min_peak ||
         kind == MotionLawKind::constant_momentum;
}

/// @throws std::invalid_argument if the ramps of a trapezoidal velocity are out of range or a law has not been found
///        yet. The message is suitable for users.
void validate(const MotionLaw& law);

/// s and its first and second derivative with respect to τ.
struct MotionLawValue {
  double s = 0, ds = 0, dds = 0;
};

/// The one-sided limit to take where the second derivative jumps.
enum class Side { before, after };

/// @param tau in [0, 1]; at 0 the side is always `after`, at 1 always `before`.
MotionLawValue evaluate(const MotionLaw& law, double tau, Side side = Side::after);

/// Values of τ in (0, 1) at which the second derivative jumps, increasing.
std::vector<double> find_acceleration_jumps(const MotionLaw& law);

}  // namespace balance::trajectory

namespace balance {

using trajectory::MotionLaw;
using trajectory::MotionLawKind;

}  // namespace balance
