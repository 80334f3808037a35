#pragma once
/// Among designs with equal figures: the one with the least added mass, then with the fewest elements, then with the
/// start values.

#include "balance/synthesis/design/problem_functions.hpp"
#include "balance/synthesis/design/solve_design.hpp"

namespace balance::design {

/// Changes the numbers of a design as far as its figure, its conditions and its limits stay the same up to round-off:
/// elements without effect vanish, elements that can replace each other share the work with the least mass, and lengths
/// and places without effect return to their start values.
/// @param u unit coordinates of the design
/// @param conditions at u
/// @return unit coordinates, u if nothing can be changed
VectorX break_ties(const SolverContext& context, const ScaledObjective& objective, const Conditions& conditions,
                   const VectorX& u);

}  // namespace balance::design
