#pragma once
/// The smallest singular value of thousands of small matrices, or of a large sparse one.

#include "balance/foundation/base/types.hpp"
#include "balance/foundation/numerics/block_triangular.hpp"

#include <functional>
#include <optional>
#include <vector>

namespace balance::numerics {

/// Householder tridiagonalisation of AᵀA, then Laguerre's iteration for its smallest eigenvalue. The iteration
/// converges from below without overshooting, cubically to a simple eigenvalue (B. N. Parlett, The Symmetric Eigenvalue
/// Problem, 1998, ch. 7; J. H. Wilkinson, The Algebraic Eigenvalue Problem, 1965, ch. 7). Values below 1e-8 of the
/// largest are round-off.
class MinSingularValue {
 public:
  /// Storage for AᵀA, to be filled before compute_from_normal_matrix() and compute_from_factors(): n × n, row-major,
  /// upper triangle.
  /// @param n at least 1
  double* normal_matrix(int n);
  /// @return the smallest singular value of A. Overwrites normal_matrix(). Allocates nothing.
  double compute_from_normal_matrix();
  /// The same in a fraction of the time for matrices that change little from one call to the next. Inverse iteration
  /// from the previous vector finds an upper bound; the pivots of AᵀA, shifted by the square of (1 − 2e-9) times this
  /// bound, prove that there is no smaller singular value. Leaves normal_matrix() unchanged. Allocates nothing. After a
  /// failure the next calls are skipped, about twice as many each time.
  /// @param factors of A, with its rows and columns in any order
  /// @return std::nullopt if skipped or undecided: slow convergence, equal singular values, a value too small to
  /// resolve from its square
  std::optional<double> compute_from_factors(BlockTriangular& factors);

 private:
  void tridiagonalise();
  bool is_below_spectrum(double value);

  int n_ = 0;
  std::vector<double> matrix_, diagonal_, off_diagonal_, vector_, image_;
  std::vector<double> shifted_;
  std::vector<double> guess_;  ///< unit right singular vector of the smallest value
  int calls_to_skip_ = 0,
      backoff_ = 0;  ///< calls of compute_from_factors() to skip: remaining, and after the last failure
};

/// The smallest singular value of a large sparse matrix to 1e-10 of the value: Lanczos iteration on (AᵀA)⁻¹ from a
/// fixed generic vector with full reorthogonalisation (Parlett, ch. 13).
/// @param matrix factorised and regular
/// @return std::nullopt if it has not converged
std::optional<double> min_singular_value_by_lanczos(BlockTriangular& matrix);

/// @param n number of columns of A
/// @param inverse x := (AᵀA)⁻¹ x
/// @param steps minimum number, unless the Krylov space is exhausted earlier
std::optional<double> min_singular_value_by_lanczos(int n, const std::function<void(VectorX&)>& inverse, int steps);

}  // namespace balance::numerics
