#pragma once
/// Global optimum of a convex set of designs, with proof.

#include "balance/synthesis/design/condition_equations.hpp"
#include "balance/synthesis/design/problem_functions.hpp"

namespace balance::design {

struct Optimum {
  VectorX u;
  double value = std::numeric_limits<double>::quiet_NaN();
  double lower_bound = std::numeric_limits<double>::quiet_NaN();  ///< of the objective, if proved
  bool is_global = false;                                         ///< value and bound agree
};

/// Improves a solution of affine conditions (if there are none: any point of the box) until a lower bound proves
/// optimality. Tangents of the objective, with multipliers for conditions and inequalities, bound it over the whole
/// box. Uses Newton's method where the objective is smooth and a proximal bundle method elsewhere.
/// @param objective convex
/// @param restore projects a point near the conditions onto them
Optimum minimise_convex(const SolverContext& context, const ScaledObjective& objective,
                        const LinearConditions& conditions, const std::function<VectorX(const VectorX&)>& restore,
                        const VectorX& start);

}  // namespace balance::design
