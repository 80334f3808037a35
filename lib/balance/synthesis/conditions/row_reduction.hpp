#pragma once
/// Reduces rows that must vanish to as few and as readable conditions as possible: rank by the gap of the singular
/// values, reduced row echelon form.

#include "balance/synthesis/conditions/conditions.hpp"

namespace balance::conditions {

/// Order of preference of the parameters for which conditions are solved: first moments and inertias, then masses,
/// springs and known terms; bodies before the elements on them, those near the ground first.
std::vector<int> order_pivots(const Mechanism& mechanism, const std::vector<dynamics::Parameter>& parameters);

/// Rows in π alone that vanish if and only if some value of the extra unknowns, the columns after π, makes all rows
/// vanish.
MatrixX eliminate_extra_unknowns(const MatrixX& rows, int parameters);

/// Sets rank, singular values, matrix, pivots and row_scales of `conditions`, whose parameters must be set.
/// @param rows any number × P, in natural units (dimensionless)
/// @param units P: SI value of each parameter's natural unit
/// @param mass of the mechanism [kg]
/// @return false if the rank is unclear; then only the singular values are set
bool reduce_conditions(const MatrixX& rows, const VectorX& units, double mass, const std::vector<int>& order,
                       Conditions& conditions);

}  // namespace balance::conditions
