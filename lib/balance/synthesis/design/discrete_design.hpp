#pragma once
/// Designs with discrete values or optional elements.
///
/// Branch and bound: each node is bounded by a convex relaxation, in which discrete variables may take values in
/// between. It is dropped if the relaxation has no design, or none better than the best one known. Where there is no
/// relaxation (lengths, figures by simulation), all combinations are tried.

#include "balance/synthesis/design/solve_design.hpp"

namespace balance::design {

/// Whether some variable or choice of the problem is discrete.
bool is_discrete(const DesignProblem& problem);

/// @param problem must be discrete
DesignOutcome solve_discrete(const DesignProblem& problem);

}  // namespace balance::design
