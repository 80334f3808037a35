#pragma once
/// Linkages that nobody designed: dyads added to cranks, with links of any number of joints, sliders and slotted links.

#include "balance/mechanics/model/mechanism.hpp"

#include <cstdint>

namespace natural_tests {

struct Recipe {
  int cranks = 1;      ///< links that turn on the ground
  int dyads = 1;       ///< pairs of links between two that are there already
  double sliders = 0;  ///< how likely a dyad has a prismatic joint
  bool gears = false;  ///< the cranks are geared to each other
};

/// All joint coordinates are zero in the configuration that it is built in; lengths, axes and masses are in general position.
balance::Mechanism random_linkage(const Recipe& recipe, std::uint32_t seed);

}  // namespace natural_tests
