#pragma once
/// Who follows whom among joint coordinates.

#include "balance/mechanics/model/mechanism.hpp"

#include <vector>

namespace balance {

// Coordinates that follow others, down to those that follow none.

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

/// Per coordinate those that lead it, none if it follows nobody.
using CouplingGraph = std::vector<std::vector<CoordinateId>>;

/// The coordinates that are followed.
template <class T>
std::vector<CoordinateId> coordinates_of(const CoordinateCombinationOf<T>& followed) {
  std::vector<CoordinateId> out;
  for (const CoordinateTermOf<T>& term : followed.terms) out.push_back(term.coordinate);
  return out;
}

/// Whether one of `from`, or what leads it, is the follower. Among `leaders` there must be no circle yet.
inline bool creates_coupling_cycle(const CouplingGraph& leaders, CoordinateId follower,
                                   const std::vector<CoordinateId>& from) {
  std::vector<bool> seen(leaders.size(), false);
  std::vector<CoordinateId> open = from;
  while (!open.empty()) {
    const CoordinateId c = open.back();
    open.pop_back();
    if (c == follower) return true;
    if (seen[static_cast<std::size_t>(c)]) continue;
    seen[static_cast<std::size_t>(c)] = true;
    const std::vector<CoordinateId>& above = leaders[static_cast<std::size_t>(c)];
    open.insert(open.end(), above.begin(), above.end());
  }
  return false;
}

}  // namespace balance
