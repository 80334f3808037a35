#pragma once
/// How the centre of mass follows the tool.

#include "balance/synthesis/conditions/conditions.hpp"

namespace balance::conditions {

/// CoM = A · tool + B₁ R e₁ (+ B₂ R e₂ + B₃ R e₃ in space) + constant, with R e the axes of the tool's body.
struct ComToolMap {
  MatrixX A;  ///< axes × axes; empty if the mechanism has no tool or cannot move
  MatrixX B;  ///< axes × axes in the plane, 3 × 9 in space [m]; zero for `proportional`
};

/// Least-squares fit over random configurations; exact if the goal's conditions are met.
/// @param kind proportional or affine
/// Source: P3 eq. 53–61
ComToolMap fit_com_tool_map(const Mechanism& mechanism, GoalKind kind, const ConditionOptions& options = {});

/// The matrix A of the goal `proportional`: the constant matrix for which CoM velocity = A · tool velocity fits best.
MatrixX fit_com_tool_matrix(const Mechanism& mechanism, const ConditionOptions& options = {});

}  // namespace balance::conditions
