#pragma once
/// What a design may claim. Private to design.

#include "balance/design/context.hpp"
#include "balance/design/solve.hpp"

namespace balance::design {

/// What the numbers were found by.
enum class SearchTarget {
  nothing,    ///< any numbers that meet the conditions
  residual,   ///< the smallest sum of squared residuals
  objective,  ///< the smallest objective
};

/// Optimality and what was tried.
/// @param proved value and bound agree
void assess_optimality(const SolverContext& context, SearchTarget what, bool proved, DesignOutcome& outcome);

/// Why no numbers have an objective: for `reason`.
std::string undefined_objective_reason(const Objective& objective, const std::string& where,
                                       const std::string& trouble);

}  // namespace balance::design
