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
void add_friction_forces(const MechanismOf<typename S::Scalar>& mechanism, const Tree<S>& tree,
                         const typename S::Scalar* dy, double duration, typename S::Scalar* tau) {
  using T = typename S::Scalar;
  double fastest = 0;
  for (int c = 0; c < tree.columns; ++c)
    fastest =
        std::max(fastest, std::abs(value_of(dy[c])) / (tree.is_length_column[c] ? tree.characteristic_length : 1));
  const double rest = rest_rate_threshold(fastest, duration);
  for (const FrictionOf<T>& friction : mechanism.friction) {
    const LinearQuantityOf<T>& source = tree.coordinate_expressions[friction.coordinate];
    const bool slides = mechanism.coordinates[friction.coordinate].kind == CoordinateKind::length;
    const T rate = source.rate(dy);
    const int sign = sliding_sign(value_of(rate), slides ? rest * tree.characteristic_length : rest);
    source.add_generalised_force(sliding_friction(friction, rate, sign), tau);
  }
}

}  // namespace balance
