#pragma once
/// From rows that must vanish to the fewest and most readable conditions: rank by the gap of the singular values, reduced row
/// echelon form.

#include "balance/synthesis/conditions/conditions.hpp"

namespace balance {

/// Preference for the parameters that conditions are solved for: first moments and inertias, then masses, then springs; bodies
/// before what they carry, those near the ground first. What comes earlier is a better pivot.
std::vector<int> order_pivots(const Mechanism& mechanism, const std::vector<Parameter>& parameters);

/// Rows of π alone, for which some value of the extra unknowns behind them makes everything vanish.
MatrixX eliminate_extra_unknowns(const MatrixX& rows, int parameters);

/// Fills in rank, singular values, matrix, pivots and scale of `conditions`, whose parameters are set.
/// @param rows any number × P, in natural units (dimensionless)
/// @param units P: SI value of each parameter's natural unit
/// @param mass the mechanism's [kg]
/// @return false if the rank is not clear; then only the singular values are filled in
bool reduce_conditions(const MatrixX& rows, const VectorX& units, double mass, const std::vector<int>& order,
                       Conditions& conditions);

}  // namespace balance
