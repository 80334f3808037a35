#pragma once
/// A first look at what the free numbers change: the mechanism at one point in general position and with every number
/// changed alone. Private to design.

#include "balance/design/box.hpp"
#include "balance/design/features.hpp"

namespace balance::designing {

struct Survey {
  VectorX base;   ///< unit coordinates in general position
  VectorX moved;  ///< per number: its other value
  Mechanism at_base;
  LooseSprings loose;           ///< springs whose ends are parameters, not geometry
  std::vector<bool> geometric;  ///< per number: it changes the geometry
  VectorX base_features;
  std::vector<VectorX> features;  ///< with number i changed alone
  double disturbed = 1e-12;       ///< relative change of a feature that counts as one

  bool any_geometric() const;
  /// Number i changes feature f.
  bool touches(int variable, int feature) const;
};

/// @param loose given by the caller; springs found to need it are added
Survey survey(const Box& box, const DesignProblem& problem);

}  // namespace balance::designing
