#pragma once
/// The best of a convex set of designs, with a proof.

#include "balance/synthesis/design/condition_equations.hpp"
#include "balance/synthesis/design/problem_functions.hpp"

namespace balance::design {

struct Optimum {
  VectorX u;
  double value = std::numeric_limits<double>::quiet_NaN();
  double lower_bound = std::numeric_limits<double>::quiet_NaN();  ///< of the objective, if proved
  bool is_global = false;                                         ///< value and bound agree
};

/// Improves a solution of affine conditions (none: any point of the box) until a lower bound proves that nothing is better:
/// tangents of the objective, with multipliers for conditions and inequalities, bound it over the whole box. Newton's method
/// where the objective is smooth, a proximal bundle method where it is not.
/// @param merit convex
/// @param restore brings a point near the conditions onto them
Optimum minimise_convex(const SolverContext& context, const ScaledObjective& merit, const LinearConditions& conditions,
                        const std::function<VectorX(const VectorX&)>& restore, const VectorX& start);

}  // namespace balance::design
