#pragma once
/// Reduces rows that must vanish to as few and as readable conditions as possible: rank by the gap of the singular
/// values, reduced row echelon form.

#include "balance/synthesis/conditions/conditions.hpp"

#include <optional>

namespace balance::conditions {

/// Order of preference of the parameters for which conditions are solved: first moments and inertias, then masses,
/// springs and known terms; bodies before the elements on them, those near the ground first.
std::vector<int> order_pivots(const Mechanism& mechanism, const std::vector<dynamics::Parameter>& parameters);

/// Rows in π alone that vanish if and only if some value of the extra unknowns, the columns after π, makes all rows
/// vanish.
MatrixX eliminate_extra_unknowns(const MatrixX& rows, int parameters);

/// Rows of orders in natural units, divided by their quantity's magnitude.
/// @param mask per term: 0 if it is left out
MatrixX scale_order_rows(const OrderRows& orders, const VectorX& units, const VectorX& mask);

/// A row of an order that may be round-off or not.
struct OrderRemainder {
  Eigen::Index row = 0;
  double size = 0;  ///< of what is left of it beside the other rows, relative to the quantity's magnitude
};

/// Adds the rows of orders to an orthonormal basis of other rows. What is left of a row beside the basis and is round-off
/// of the quantity as a whole adds nothing.
/// @param rows scale_order_rows()
/// @param basis rows × P in natural units; more rows on return
std::optional<OrderRemainder> add_order_rows(const MatrixX& rows, MatrixX& basis);

/// An orthonormal basis of the conditions' rows in natural units.
MatrixX condition_basis(const Conditions& conditions, const VectorX& units);

/// Sets rank, singular values, matrix, pivots and row_scales of `conditions`, whose parameters must be set.
/// @param rows any number × P, in natural units (dimensionless)
/// @param units P: SI value of each parameter's natural unit
/// @param mass of the mechanism [kg]
/// @return false if the rank is unclear; then only the singular values are set
bool reduce_conditions(const MatrixX& rows, const VectorX& units, double mass, const std::vector<int>& order,
                       Conditions& conditions);

}  // namespace balance::conditions
