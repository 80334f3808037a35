#pragma once
/// A limited quantity at a moment of a motion along a path, with its derivatives. Private to timing.

#include "balance/timing/path_model.hpp"

namespace balance {

/// A moment on a path, and the row that matters there.
struct PathPoint {
  double s = 0, v = 0, u = 0;  ///< s, s', s''
  int row = 0;
};

/// a u + b x + c + d√x with x = v², less its middle.
struct ConstraintValue {
  VectorX value;  ///< of every component
  double magnitude = 0;
  double d_du = 0, d_dx = 0;  ///< derivatives of the magnitude
  bool is_velocity_limited =
      false;  ///< a vanishes, or is at right angles to the value: u does not change the magnitude
};

ConstraintValue evaluate_constraint(const PathModel& model, const PathPoint& moment);

}  // namespace balance
