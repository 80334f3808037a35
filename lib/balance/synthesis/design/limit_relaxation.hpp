#pragma once
/// Limits that proofs do not cover: first the same problem without them.

#include "balance/synthesis/design/solve_design.hpp"

#include <functional>

namespace balance::design {

/// Sets the figures of the limits at the outcome's design, and whether they are kept.
void evaluate_limits(const DesignProblem& problem, DesignOutcome& outcome);

/// The largest violation of a limit; 0 if all are satisfied.
double max_limit_violation(const DesignOutcome& outcome);

/// Solves a problem with limits. If some of them are not convex, although the rest of the problem is, its optimum without
/// these limits is found first: if it keeps them, it is the optimum, and in any case its lower bound holds. A start that
/// keeps all limits is a design, so that the answer never is that none was found.
/// @param search solves problems with limits of all kinds
DesignOutcome solve_with_limits(const DesignProblem& problem,
                                const std::function<DesignOutcome(const DesignProblem&)>& search);

}  // namespace balance::design
