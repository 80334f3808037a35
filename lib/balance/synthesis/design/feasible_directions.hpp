#pragma once
/// Directions in which the free numbers may change: null spaces, and the cone that active constraints leave.

#include "balance/synthesis/design/solver_context.hpp"

namespace balance::design {

/// A direction with a relative component below this does not move the variable.
inline constexpr double null_space_tolerance = 1e-6;

/// Orthonormal basis of the null space of `rows` within the span of `basis`.
MatrixX restrict_to_null_space(const MatrixX& basis, const MatrixX& rows, double tolerance);

/// Normals of the constraints active at u: bounds, physical constraints and limits. Feasible directions have no
/// negative product with them.
MatrixX active_constraint_normals(const SolverContext& context, const VectorX& u);

/// The linear span of the feasible directions within the span of `basis`. Limits that no feasible direction leaves are
/// equalities.
/// @param limits normals of the active constraints
MatrixX span_feasible_directions(const MatrixX& basis, const MatrixX& limits);

}  // namespace balance::design
