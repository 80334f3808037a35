#pragma once
/// Friction law of a joint coordinate, shared by all formulations.

#include "balance/mechanics/model/mechanism.hpp"

#include <cmath>

namespace balance::model {

/// Rates below this fraction of the largest rate of any coordinate are round-off. So are rates below this fraction of
/// one radian (one characteristic length) per motion: a slanted gantry that is at rest in one direction moves by 1e-17.
inline constexpr double rest_rate_tolerance = 1e-11;

/// Rates up to this threshold count as rest. Coordinates are in radians or characteristic lengths.
/// @param max_rate largest rate of any coordinate at this moment [rad/s, or characteristic lengths per second]
/// @param duration duration of the motion [s]
inline double rest_rate_threshold(double max_rate, double duration) {
  return rest_rate_tolerance * std::max(max_rate, 1 / duration);
}

/// Direction of sliding: −1, 1, or 0 for a coordinate at rest.
/// @param rest_threshold rest_rate_threshold(), for slides multiplied by the characteristic length
inline int sliding_sign(double rate, double rest_threshold) {
  return std::abs(rate) <= rest_threshold ? 0 : rate > 0 ? 1 : -1;
}

/// Resistance of a sliding coordinate [N m or N]. At rest (sign 0) only the viscous part remains.
template <class T>
T sliding_friction(const FrictionOf<T>& friction, const T& rate, int sign) {
  return friction.viscous * rate + friction.dry_friction(sign) * sign;
}

}  // namespace balance::model
