#pragma once
/// The speeds from which a leg's end can be reached within the limits. Private to timing.

#include "balance/timing/stretches.hpp"

#include <string>
#include <vector>

namespace balance {

/// A braking arc that bounds the speeds, up to where it leaves the ceiling of what is allowed at all, or to the leg's end.
struct BrakingArc {
  Arc nodes;              ///< ascending; t from its first node
  int zero_inertia = -1;  ///< the row that vanishes where it ends; −1: none

  double begin() const { return nodes.front().s; }
  double end() const { return nodes.back().s; }
};

/// Between two arcs the ceiling is the bound.
struct Controllable {
  std::vector<BrakingArc> arcs;  ///< ascending, the last one ends with the leg
  std::string refusal;           ///< why there are none; empty: there are

  /// The arc that holds a place, or nothing.
  const BrakingArc* at(double place) const;
};

/// @param end_rate s' at the leg's end
Controllable find_controllable(Allowed& allowed, const LegOfPath& leg, double end_rate);

/// Where an arc stands at a place of its own.
ArcNode node_at(const Arc& arc, double place);

/// "at 30 % of the path".
std::string place_text(double place);

}  // namespace balance
