#pragma once
/// A path with a width: how it is left is found for the mechanism.

#include <vector>

namespace balance {

/// The driven point may leave its path, which is a line, a circle or an arc, at right angles to it; where joints are driven their
/// coordinates may, as one point. Both ends stay. Derivation: docs/motion.md.
template <class T>
struct CorridorOf {
  T width = 0;          ///< how far at most, to every side [m or rad], positive
  int inner_knots = 7;  ///< inner ones of the cubic splines that the offset is made of, evenly spaced
  int starts = 3;       ///< of the search
  std::vector<double>
      control_points;  ///< of the splines, knots + 2 for each direction [m or rad]; empty: not found yet
};

}  // namespace balance
