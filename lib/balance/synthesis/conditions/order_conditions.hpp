#pragma once
/// The rows of orders one by one, as they are printed: each solved for a parameter of its own.

#include "balance/synthesis/conditions/conditions.hpp"

#include <vector>

namespace balance::conditions {

struct OrderConditions {
  Conditions conditions;          ///< matrix, pivots, row_scales and parameters of rows that are more than round-off
  VectorX factors;                ///< the order's amplitude is its factor [SI] times the condition
  std::vector<std::size_t> rows;  ///< per condition: index into Conditions::orders.rows
};

/// @param derived with orders, status done
OrderConditions list_order_conditions(const Mechanism& mechanism, const Conditions& derived,
                                      const ConditionOptions& options);

/// Amplitudes of all rows of orders [SI], 0 where they are round-off of the quantity.
VectorX evaluate_order_rows(const Mechanism& mechanism, const Conditions& derived, const ConditionOptions& options);

/// The same rows, solved for the same parameters, of a mechanism with other lengths; not `done` if it has none.
Conditions rederive_order_conditions(const Mechanism& mechanism, const OrderConditions& known,
                                     const ConditionOptions& options);

}  // namespace balance::conditions
