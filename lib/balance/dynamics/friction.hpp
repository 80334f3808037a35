#pragma once
/// Joint friction of a tree in motion. Private to dynamics and the rooms that open it up.

#include "balance/kinematics/tree.hpp"
#include "balance/model/friction.hpp"

#include <algorithm>

namespace balance {

/// Adds what friction takes to the generalised forces; coordinates at rest count as frictionless (docs/theory.md, section 3).
/// @param dy rates of the tree's coordinates @param duration of the whole motion [s]
/// @param tau per tree coordinate [N m or N]
template <class S>
void add_friction(const Mechanism& mechanism, const Tree<S>& tree, const double* dy, double duration, double* tau) {
  double fastest = 0;
  for (int c = 0; c < tree.columns; ++c)
    fastest = std::max(fastest, std::abs(dy[c]) / (tree.column_kind_length[c] ? tree.length : 1));
  const double rest = rest_rate(fastest, duration);
  for (const Friction& friction : mechanism.friction) {
    const CoordinateSource& source = tree.sources[friction.coordinate];
    const bool slides = mechanism.coordinates[friction.coordinate].kind == CoordinateKind::length;
    const double rate = source.ratio * dy[source.column];
    const int sign = sliding_sign(rate, slides ? rest * tree.length : rest);
    tau[source.column] += source.ratio * sliding_friction(friction, rate, sign);
  }
}

}  // namespace balance
