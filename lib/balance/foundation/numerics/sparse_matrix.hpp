#pragma once
/// Large sparse matrices of any shape: damped least-squares steps and the smallest singular value.

#include "balance/foundation/base/types.hpp"
#include "balance/foundation/numerics/block_triangular.hpp"

#include <Eigen/SparseCore>

#include <optional>

namespace balance::numerics {

using SparseMatrix = Eigen::SparseMatrix<double>;

/// (AᵀA + μ)⁻¹ Aᵀ b = Aᵀ (AAᵀ + μ)⁻¹ b, by the form with fewer entries, so that neither a full row nor a full column
/// makes it dense.
/// @param shift μ > 0
VectorX solve_damped_least_squares(const SparseMatrix& A, const VectorX& b, double shift);

/// The smallest of the min(m, n) singular values of an m × n matrix, by Lanczos iteration on the inverse of AAᵀ or AᵀA
/// from a fixed generic vector. The estimate is never below the true value, and at least twice as large only with a
/// probability below 1.65 √n exp(−√3 (k − ½)) after k steps (J. Kuczyński & H. Woźniakowski, SIAM J. Matrix Anal. Appl.
/// 13, 1992, theorem 4.1).
/// @return std::nullopt if it has not converged or is too small (below 1e-6 ‖A‖) to resolve from its square
std::optional<double> min_singular_value(const SparseMatrix& A);

}  // namespace balance::numerics
