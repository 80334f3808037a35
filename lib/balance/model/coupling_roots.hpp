#pragma once
/// Coordinates that follow others, down to those that follow none.

#include "balance/model/mechanism.hpp"

#include <vector>

namespace balance {

/// q[c] = ratio · q[coordinate] + offset.
template <class T>
struct CouplingRootOf {
  int coordinate;  ///< follows no other
  T ratio = 1, offset = 0;
};

/// One per coordinate c of the mechanism.
/// @throws std::invalid_argument if couplings follow each other in a circle
template <class T>
std::vector<CouplingRootOf<T>> coupling_roots(const MechanismOf<T>& mechanism);

}  // namespace balance
