#pragma once
/// Geometries of measure zero that need fewer conditions than their neighbours, so that a bound for general lengths
/// says nothing about them.
///
/// A linkage with one loop: any further relation P₁ e₁ + P₂ e₂ = K of a moving four-bar (the rocker eliminated by the
/// closure) holds on an arc only if P₁ = 0, K ≠ 0, or K = 0. In the first case the coupler keeps its direction: the
/// linkage is a parallelogram, its closure splits into one for the coupler and one for crank and rocker, and both are
/// weaker conditions. In the second case crank and coupler turn as one body about a rocker at rest: a kite, folded.

#include "balance/synthesis/certificate/assembly_conditions.hpp"
#include "balance/synthesis/certificate/loop_closures.hpp"

namespace balance::certificate {

/// Lengths, closures and bounds of one geometry.
struct SpecialGeometry {
  std::string name;  ///< "crank–coupler–rocker a parallelogram"
  LengthSubstitution substitution;
  std::vector<LoopClosure> closures;        ///< instead of the linkage's, before the substitution
  std::vector<LengthCondition> equalities;  ///< that no substitution expresses
  LengthBox box;                            ///< contains all its lengths
};

struct SpecialGeometries {
  std::vector<SpecialGeometry> geometries;
  std::vector<std::string> uncovered;  ///< geometries within the box that are not among them
};

/// All parallelograms, and sets of several, that lengths of the box may form.
SpecialGeometries find_special_geometries(const PlanarLinkage& linkage, const LengthBox& box);

}  // namespace balance::certificate
