#pragma once
/// What a design says about its conditions: which numbers occur in them, which stay open, why they cannot be met. Private to
/// design.

#include "balance/design/equations.hpp"
#include "balance/design/solve.hpp"

namespace balance::designing {

/// Per condition the free numbers that change what it says. @param u where conditions were derived, of any geometry
std::vector<std::vector<int>> find_occurring(const Context& context, const Conditions& conditions, const VectorX& u);

/// Proof that the conditions of a fixed geometry cannot be met, for any masses or within the bounds.
/// @param residual what the best numbers leave
std::optional<Impossibility> find_proof(const Context& context, const Conditions& conditions, const FixedRows& rows,
                                        const VectorX& residual);

/// Status, open conditions and reason from residuals, proof and fixed conditions.
void conclude(DesignOutcome& outcome);

}  // namespace balance::designing
