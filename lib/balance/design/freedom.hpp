#pragma once
/// How many ways there are to change a design without losing anything. Private to design.

#include "balance/design/exact.hpp"
#include "balance/design/figure_of_merit.hpp"
#include "balance/design/solve.hpp"

namespace balance::design {

/// Dimension of the set of solutions near u: the null space of the conditions' Jacobian, less what bounds and physical limits
/// that u lies on do not allow. With an objective also of the solutions that are as good: directions along which its value
/// changes, or curves, do not count.
/// @param merit null: none
/// @param precise the Jacobian is exact, not made by differences
SolutionSet analyse_solution_set(const SolverContext& context, const NonlinearSystem& equations,
                                 const ScaledObjective* merit, const VectorX& u, bool precise);

}  // namespace balance::design
