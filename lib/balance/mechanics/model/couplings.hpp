#pragma once
/// Couplings between joint coordinates.

#include "balance/mechanics/model/mechanism.hpp"

#include <vector>

namespace balance::model {

// Couplings resolved to coordinates that follow no other.

/// q[c] = Σ ratio · q[coordinate] + offset.
template <class T>
struct ResolvedCouplingOf {
  std::vector<CoordinateTermOf<T>> terms;  ///< coordinates that follow no other, each at most once
  T offset = 0;
};

/// Returns one entry per coordinate c of the mechanism.
/// @throws std::invalid_argument if couplings form a cycle
template <class T>
std::vector<ResolvedCouplingOf<T>> resolve_couplings(const MechanismOf<T>& mechanism);

/// The leaders of each coordinate; empty if it follows none.
using CouplingGraph = std::vector<std::vector<CoordinateId>>;

/// The followed coordinates.
template <class T>
std::vector<CoordinateId> coordinates_of(const CoordinateCombinationOf<T>& followed) {
  std::vector<CoordinateId> out;
  for (const CoordinateTermOf<T>& term : followed.terms) out.push_back(term.coordinate);
  return out;
}

/// Whether one of `from`, or one of their direct or indirect leaders, is `follower`. `leaders` must not contain a cycle
/// yet.
inline bool creates_coupling_cycle(const CouplingGraph& leaders, CoordinateId follower,
                                   const std::vector<CoordinateId>& from) {
  std::vector<bool> visited(leaders.size(), false);
  std::vector<CoordinateId> pending = from;
  while (!pending.empty()) {
    const CoordinateId c = pending.back();
    pending.pop_back();
    if (c == follower) return true;
    if (visited[static_cast<std::size_t>(c)]) continue;
    visited[static_cast<std::size_t>(c)] = true;
    const std::vector<CoordinateId>& next_leaders = leaders[static_cast<std::size_t>(c)];
    pending.insert(pending.end(), next_leaders.begin(), next_leaders.end());
  }
  return false;
}

}  // namespace balance::model
