#pragma once
/// Proofs for designs whose conditions are products of masses and places. Private to design.

#include "balance/design/solve.hpp"

namespace balance::design {

/// Where masses and first moments make a convex problem of the numbers: its least figure is a bound of every design's, and what it leaves of the
/// conditions, if anything, is left by every choice of the numbers.
/// @param again the search from other start values
void bound_by_relaxation(const DesignProblem& problem, DesignOutcome& outcome,
                         const std::function<DesignOutcome(const DesignProblem&)>& again);

}  // namespace balance::design
