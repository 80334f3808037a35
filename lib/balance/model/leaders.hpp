#pragma once
/// Who follows whom among joint coordinates.

#include "balance/model/mechanism.hpp"

#include <vector>

namespace balance {

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
bool creates_coupling_cycle(const CouplingGraph& leaders, CoordinateId follower, const std::vector<CoordinateId>& from);

}  // namespace balance
