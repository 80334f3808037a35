#pragma once
/// Coordinates that follow others, down to those that follow none.

#include "balance/model/mechanism.hpp"

#include <vector>

namespace balance {

/// q[c] = ratio · q[coordinate] + offset.
struct CouplingRoot {
  int coordinate;  ///< follows no other
  double ratio = 1, offset = 0;
};

/// One per coordinate c of the mechanism.
/// @throws std::invalid_argument if couplings follow each other in a circle
std::vector<CouplingRoot> coupling_roots(const Mechanism& mechanism);

}  // namespace balance
