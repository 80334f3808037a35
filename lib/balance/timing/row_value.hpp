#pragma once
/// A limited quantity at a moment of a motion along a path, with its derivatives. Private to timing.

#include "balance/timing/path_model.hpp"

namespace balance {

/// A moment on a path, and the row that matters there.
struct PathMoment {
  double s = 0, v = 0, u = 0;  ///< s, s', s''
  int row = 0;
};

/// a u + b x + c + d√x with x = v², less its middle.
struct RowValue {
  VectorX value;  ///< of every component
  double magnitude = 0;
  double by_u = 0, by_x = 0;  ///< derivatives of the magnitude
  bool tangent = false;       ///< a vanishes, or is at right angles to the value: u does not change the magnitude
};

RowValue value_of_row(const PathModel& model, const PathMoment& moment);

}  // namespace balance
