#pragma once
/// How the centre of mass follows the tool.

#include "balance/conditions/conditions.hpp"

namespace balance {

/// The constant matrix A (axes × axes) for which CoM velocity = A · tool velocity fits best over random configurations; exact
/// where the conditions of the goal `proportional` are met. Empty if the mechanism has no tool or cannot move.
/// Source: P3 eq. 53–60
MatrixX com_per_tool(const Mechanism& mechanism, const ConditionOptions& options = {});

}  // namespace balance
