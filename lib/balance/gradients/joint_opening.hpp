#pragma once
/// Changes of a number that over-constrained loops cannot follow: no mechanism has the number changed by itself, and what its change
/// does to a run is no derivative.

#include "balance/model/ids.hpp"

#include <vector>

namespace balance {

/// What a joint opens by per unit of a number while all others are held together, coordinates being moved so that it is least.
struct ClosureGap {
  JointId joint;
  bool is_length = false;  ///< else an angle
  double gap = 0;          ///< [m] or [rad] per unit of the number
};

/// Of one number; empty if the loops follow it.
using ClosureGaps = std::vector<ClosureGap>;

}  // namespace balance
