#pragma once
/// A joint with friction while the mechanism moves. Private to control.

#include "balance/kinematics/linear_quantity.hpp"
#include "balance/model/friction.hpp"

namespace balance {

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

}  // namespace balance
