#pragma once
/// Small strictly convex quadratic programs.

#include "balance/foundation/base/types.hpp"

#include <optional>

namespace balance::numerics {

/// Minimise ½ xᵀ H x + gᵀ x subject to E x = e and C x ≥ c.
struct QuadraticProgram {
  MatrixX hessian;  ///< symmetric positive definite
  VectorX gradient;
  MatrixX equalities;               ///< E
  VectorX equality_values;          ///< e
  MatrixX inequalities;             ///< C
  VectorX inequality_lower_bounds;  ///< c
};

struct QuadraticOptimum {
  VectorX x;
  VectorX equality_multipliers;    ///< H x + g = Eᵀ y + Cᵀ z
  VectorX inequality_multipliers;  ///< not negative
};

/// @return std::nullopt if the constraints contradict each other
/// Source: Goldfarb & Idnani, A numerically stable dual method for solving strictly convex quadratic programs,
/// Mathematical Programming 27 (1983); every step factorises the active set anew.
std::optional<QuadraticOptimum> solve_quadratic_program(const QuadraticProgram& program);

}  // namespace balance::numerics
