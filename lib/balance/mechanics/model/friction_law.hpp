#pragma once
/// The law of friction in a joint coordinate, the same for all formulations.

#include "balance/mechanics/model/mechanism.hpp"

#include <cmath>

namespace balance {

/// Rates below this part of the largest rate of any coordinate are round-off, and so are those below the same part of one
/// radian (one characteristic length) in a whole motion: what rests in one direction of a slanted gantry moves by 1e-17.
inline constexpr double rest_rate_tolerance = 1e-11;

/// Rates up to this are rest, for one radian or one characteristic length as the unit of coordinates.
/// @param fastest largest rate of any coordinate at this moment [rad/s, or characteristic lengths per second]
/// @param duration of the motion [s]
inline double rest_rate_threshold(double fastest, double duration) {
  return rest_rate_tolerance * std::max(fastest, 1 / duration);
}

/// The direction of a sliding motion: −1, 1, or 0 for a coordinate at rest.
/// @param rest as rest_rate_threshold(), times the characteristic length for a slide
inline int sliding_sign(double rate, double rest) { return std::abs(rate) <= rest ? 0 : rate > 0 ? 1 : -1; }

/// What a coordinate that slides resists with [N m or N]; one at rest, with sign 0, by its viscous part alone.
template <class T>
T sliding_friction(const FrictionOf<T>& friction, const T& rate, int sign) {
  return friction.viscous * rate + friction.dry_friction(sign) * sign;
}

}  // namespace balance
