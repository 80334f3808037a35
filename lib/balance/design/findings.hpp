#pragma once
/// What a design says about its conditions: which numbers occur in them, which stay open, why they cannot be met. Private to
/// design.

#include "balance/design/equations.hpp"
#include "balance/design/solve.hpp"

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

}  // namespace balance::design
