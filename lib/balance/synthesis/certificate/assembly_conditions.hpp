#pragma once
/// Inequalities in the lengths that every design that can be assembled along given motions meets.
///
/// Where the directions of the driven links or the place of the tool are prescribed, a loop with two other links must
/// close: L_p e_p + L_q e_q + v = 0 with a known vector v(l), which requires ||L_p| − |L_q|| ≤ |v| ≤ |L_p| + |L_q|.
/// With one other link and a slide along a known direction, the link must reach the line: |L_p| ≥ the distance of v from
/// it. A slide along the only other link, with the offset h of its line, requires |v| ≥ |h|.
/// Other loops are left out, which only weakens a bound.

#include "balance/synthesis/certificate/bernstein_form.hpp"
#include "balance/synthesis/certificate/loop_closures.hpp"

namespace balance::certificate {

/// p(l) ≥ 0, or p(l) = 0.
struct LengthCondition {
  LengthPolynomial polynomial;
  bool is_equality = false;
};

/// Conditions of the poses that the trajectories prescribe: their ends, waypoints, and for a single driven joint poses
/// between the ends.
/// @param trajectories indices of those that every design must follow
std::vector<LengthCondition> list_assembly_conditions(const DesignSpace& space, const PlanarLinkage& linkage,
                                                      const std::vector<int>& trajectories, const LengthBox& box);

/// Lengths that a condition removes from a box: those on one side of a value of one length.
struct BoxCut {
  int length = -1;  ///< −1: all lengths that are left
  double at = 0;
  bool is_lower_removed = false;
  int condition = 0;
};

/// Removes lengths of the box that do not meet the conditions.
/// @param cuts receives what was removed, one after the other; null: nobody asks
/// @return false if none are left
bool contract(const std::vector<LengthCondition>& conditions, LengthBox& box, std::vector<BoxCut>* cuts = nullptr);

}  // namespace balance::certificate
