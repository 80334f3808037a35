#pragma once
/// Lengths and ratios as free numbers: a search on two levels.

#include "balance/synthesis/design/condition_equations.hpp"
#include "balance/synthesis/design/problem_functions.hpp"
#include "balance/synthesis/design/solve_design.hpp"

namespace balance::design {

/// What the search found.
struct GeometrySearchResult {
  VectorX u;
  bool is_found = false;            ///< assembled, moving and with a value of the objective, if there is one
  bool is_balanced = false;         ///< all conditions of u's geometry are met
  bool minimises_residual = false;  ///< a compromise that leaves the least of the conditions; else the least objective
  std::optional<VectorX>
      balanced_without_value;  ///< not balanced: numbers that balance, where the objective has no value
};

/// Above: lengths and ratios, from the start and from points that fill their box. Below, at each of them: the other numbers,
/// for which the conditions are those of one geometry and most objectives are convex. Where conditions can be met at special
/// lengths only, Gauss–Newton on all numbers at once ends there.
/// @param anchor unit coordinates with which the mechanism can be assembled and conditions can be derived
/// @param equations make_geometry_equations from there, or none
/// @param merit null: none
GeometrySearchResult search_geometry(const SolverContext& context, const VectorX& anchor,
                                     const NonlinearSystem& equations, const ScaledObjective* merit);

/// Unit coordinates with which the mechanism can be assembled and follows what it must: the start, or a point near it; nothing if
/// none is found.
/// @param reason why the start is none
std::optional<VectorX> find_feasible_start(const SolverContext& context, std::string& reason);

/// Lengths next to a simple multiple of another number of the geometry, put there; nothing if there are none. Conditions that
/// fall together at special lengths can be told from others only at these very lengths.
std::optional<VectorX> snap_to_length_ratios(const SolverContext& context, const VectorX& u);

}  // namespace balance::design
