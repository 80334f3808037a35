#pragma once
/// Designs whose numbers come in sizes or whose elements are to be chosen among.
///
/// Branch and bound: a branch is bounded by a convex problem in which sizes may lie between each other (relaxation), and dropped
/// where that holds no design, or none better than the best one known. Where there is no such problem (lengths, figures by
/// simulation) all combinations are tried.

#include "balance/synthesis/design/solve_design.hpp"

namespace balance::design {

/// Something of the problem is not continuous.
bool is_discrete(const DesignProblem& problem);

/// @param problem is_discrete
DesignOutcome solve_discrete(const DesignProblem& problem);

}  // namespace balance::design
