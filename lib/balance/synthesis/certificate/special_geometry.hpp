#pragma once
/// Geometries of measure zero that need fewer conditions than their neighbours, so that a bound for general lengths
/// says nothing about them.
///
/// A linkage with one loop: any further relation P₁ e₁ + P₂ e₂ = K of a moving four-bar (the rocker eliminated by the
/// closure) holds on an arc only if P₁ = 0, K ≠ 0, or K = 0. In the first case the coupler keeps its direction: the
/// linkage is a parallelogram, its closure splits into one for the coupler and one for crank and rocker, and both are
/// weaker conditions. In the second case crank and coupler turn as one body about a rocker at rest: a kite, folded.
///
/// A slider-crank (e₁, e₂ and the ground's slide s): the same with s eliminated. P₁ = 0 or P₂ = 0 holds a link still, and
/// K = 0 turns crank and rod as one, which takes equal lengths in line with the slide. With these lengths the other way
/// to move has e₂ = ē₁, which statics along the slide can use. Statics ask whether Re(P₁ e₁ + P₂ e₂) is constant where
/// Im(L₁ e₁ + L₂ e₂) is; both are Laurent polynomials of the same terms, and the second has no factors but with equal
/// lengths in line. A slide along a rotating lever (e₁, e₂, s e₂): s e₂ eliminated, P₁ e₁ + P₂ e₂ = K would hold one of
/// them still, or turn both as one, which takes coinciding bearings, or a slide through the lever's bearing that the
/// crank's pin reaches. With a further link, the surface of possible directions is irreducible, and no such relation
/// contains it. Two slides of the ground follow from any directions of the links by linear equations.

/// Moments: the angular momentum is a sum of forms A_uv (virtual_linkage.hpp). On a four-bar's curve F(e₁, e₂) = 0, a
/// Laurent polynomial whose Newton polygon is a hexagon, such a sum that vanishes is a multiple F · Q, and Q has the same
/// polygon; comparing coefficients from the vertices inwards leaves Q = 0 and no sum but those that the closure implies.
/// So all lengths with an irreducible F have the same conditions. F is reducible where two pairs of sides are equal: in
/// parallelograms and kites, whose lengths are bounded by their forces alone. In a slider-crank the coefficients leave
/// only equal lengths in line with the slide, as above. A further link, held still, makes a loop of five links a four-bar
/// with another ground: the same for all its lengths.

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
