#pragma once
/// Analysis of a design's conditions: which variables occur in them, which conditions are unmet, and why they cannot be
/// met.

#include "balance/synthesis/design/condition_equations.hpp"
#include "balance/synthesis/design/problem_functions.hpp"
#include "balance/synthesis/design/solve_design.hpp"
#include "balance/synthesis/design/solver_context.hpp"

namespace balance::design {

/// For each condition, the free variables that change it. @param u point at which the conditions were derived; the
/// geometry may be free
std::vector<std::vector<int>> find_condition_variables(const SolverContext& context, const Conditions& conditions,
                                                       const VectorX& u);

/// Proof that the conditions at a fixed geometry cannot be met, either for any masses or within the bounds.
/// @param residual of the best design
std::optional<InfeasibilityCertificate> find_infeasibility_certificate(const SolverContext& context,
                                                                       const Conditions& conditions,
                                                                       const ConditionResidual& rows,
                                                                       const VectorX& residual);

/// Derives status, unmet conditions and reason from the residuals, the proof and the fixed conditions.
void determine_status(DesignOutcome& outcome);

// Dimension of the set of equivalent designs.

/// Dimension of the set of solutions near u: the null space of the conditions' Jacobian, restricted by the bounds and
/// physical limits active at u. With an objective, also the dimension of the set of optimal solutions, which excludes
/// directions along which the objective has slope or curvature.
/// @param objective nullptr: no objective
/// @param precise whether the Jacobian is exact rather than computed by differences
SolutionSet analyse_solution_set(const SolverContext& context, const NonlinearSystem& equations,
                                 const ScaledObjective* objective, const VectorX& u, bool precise);

// Optimality claims of a design.

/// What the search optimised.
enum class SearchTarget {
  nothing,    ///< any solution of the conditions
  residual,   ///< the sum of squared residuals
  objective,  ///< the objective
};

/// Sets the optimality and the summary of the search.
/// @param proved whether value and lower bound agree
void assess_optimality(const SolverContext& context, SearchTarget target, bool proved, DesignOutcome& outcome);

/// Message for `reason` if no design has a value of the objective.
std::string undefined_objective_reason(const Objective& objective, const std::string& where,
                                       const std::string& failure_reason);

/// "peak(torque) <= 12 is missed by 3.2 % of its bound": the limit with the largest violation.
std::string describe_worst_limit(const std::vector<DesignLimit>& limits, const std::vector<LimitOutcome>& outcomes);

}  // namespace balance::design
