#pragma once
/// A first look at what the free numbers change: the mechanism at one point in general position and with every number
/// changed alone. Private to design.

#include "balance/design/box.hpp"
#include "balance/design/features.hpp"

namespace balance::design {

struct VariableClassification {
  VectorX base;       ///< unit coordinates in general position
  VectorX perturbed;  ///< per number: its other value
  Mechanism base_mechanism;
  FreeSprings loose_springs;       ///< springs whose ends are parameters, not geometry
  std::vector<bool> is_geometric;  ///< per number: it changes the geometry
  VectorX base_features;
  std::vector<VectorX> perturbed_features;  ///< with number i changed alone
  double change_threshold = 1e-12;          ///< relative change of a feature that counts as one

  bool has_geometric() const;
  /// Number i changes feature f.
  bool has_effect(int variable, int feature) const;
};

/// @param loose given by the caller; springs found to need it are added
VariableClassification classify_variables(const VariableScaling& box, const DesignProblem& problem);

}  // namespace balance::design
