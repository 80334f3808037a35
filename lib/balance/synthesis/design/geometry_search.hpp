#pragma once
/// Bilevel search for lengths and ratios as free numbers.

#include "balance/synthesis/design/condition_equations.hpp"
#include "balance/synthesis/design/problem_functions.hpp"
#include "balance/synthesis/design/solve_design.hpp"

namespace balance::design {

/// Result of the search.
struct GeometrySearchResult {
  VectorX u;
  bool is_found = false;            ///< can be assembled, moves, and the objective, if any, has a value
  bool is_balanced = false;         ///< all conditions at the geometry of u are met
  bool minimises_residual = false;  ///< compromise with minimum residual of the conditions, not objective
  std::optional<VectorX>
      balanced_without_value;  ///< if not balanced: a balanced point at which the objective has no value
};

/// The upper level varies lengths and ratios, from the start and from space-filling points. The lower level solves for
/// the other variables at fixed lengths, where the conditions are those of a single geometry and most objectives are
/// convex. If the conditions can be met only at special lengths, Gauss–Newton on all variables at once converges to
/// them.
/// @param anchor unit coordinates at which the mechanism can be assembled and conditions can be derived
/// @param equations make_geometry_equations at the anchor; may be empty
/// @param objective nullptr: no objective
GeometrySearchResult search_geometry(const SolverContext& context, const VectorX& anchor,
                                     const numerics::NonlinearSystem& equations, const ScaledObjective* objective);

/// Unit coordinates at which the mechanism can be assembled and follows its required motions: the start or a point near
/// it. std::nullopt if none is found.
/// @param reason why the start is infeasible
std::optional<VectorX> find_feasible_start(const SolverContext& context, std::string& reason);

/// Moves lengths that nearly equal a simple multiple of another number of the geometry exactly onto it; std::nullopt if
/// there are none. Conditions that coincide at special lengths can be recognised only at exactly these lengths.
std::optional<VectorX> snap_to_length_ratios(const SolverContext& context, const VectorX& u);

}  // namespace balance::design
