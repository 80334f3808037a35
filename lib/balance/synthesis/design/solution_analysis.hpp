#pragma once
/// What a design says about its conditions: which numbers occur in them, which stay open, why they cannot be met.

#include "balance/synthesis/design/condition_equations.hpp"
#include "balance/synthesis/design/problem_functions.hpp"
#include "balance/synthesis/design/solve_design.hpp"
#include "balance/synthesis/design/solver_context.hpp"

namespace balance::design {

/// Per condition the free numbers that change what it says. @param u where conditions were derived, of any geometry
std::vector<std::vector<int>> find_condition_variables(const SolverContext& context, const Conditions& conditions,
                                                       const VectorX& u);

/// Proof that the conditions of a fixed geometry cannot be met, for any masses or within the bounds.
/// @param residual what the best numbers leave
std::optional<InfeasibilityCertificate> find_infeasibility_certificate(const SolverContext& context,
                                                                       const Conditions& conditions,
                                                                       const ConditionResidual& rows,
                                                                       const VectorX& residual);

/// Status, open conditions and reason from residuals, proof and fixed conditions.
void determine_status(DesignOutcome& outcome);

// How many ways there are to change a design without losing anything.

/// Dimension of the set of solutions near u: the null space of the conditions' Jacobian, less what bounds and physical limits
/// that u lies on do not allow. With an objective also of the solutions that are as good: directions along which its value
/// changes, or curves, do not count.
/// @param merit null: none
/// @param precise the Jacobian is exact, not made by differences
SolutionSet analyse_solution_set(const SolverContext& context, const NonlinearSystem& equations,
                                 const ScaledObjective* merit, const VectorX& u, bool precise);

// What a design may claim.

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
