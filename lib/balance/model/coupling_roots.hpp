#pragma once
/// Coordinates that follow others, down to those that follow none.

#include "balance/model/mechanism.hpp"

#include <vector>

namespace balance {

/// q[c] = Σ ratio · q[coordinate] + offset.
template <class T>
struct ResolvedCouplingOf {
  std::vector<CoordinateTermOf<T>> terms;  ///< coordinates that follow no other, each once
  T offset = 0;
};

/// One per coordinate c of the mechanism.
/// @throws std::invalid_argument if couplings follow each other in a circle
template <class T>
std::vector<ResolvedCouplingOf<T>> resolve_couplings(const MechanismOf<T>& mechanism);

}  // namespace balance
