#pragma once
/// The smallest singular value of a matrix, for thousands of small ones.

#include "balance/foundation/base/types.hpp"
#include "balance/foundation/numerics/block_triangular.hpp"

#include <functional>
#include <optional>
#include <vector>

namespace balance {

/// Householder's tridiagonal form of AᵀA, then Laguerre's iteration for its smallest eigenvalue: from below, without ever passing it,
/// each step cubing the error of a simple one (B. N. Parlett, The Symmetric Eigenvalue Problem, 1998, ch. 7; J. H. Wilkinson, The Algebraic
/// Eigenvalue Problem, 1965, ch. 7). Values below 1e-8 of the largest are round-off.
class MinSingularValue {
 public:
  /// Room for AᵀA, to be filled before compute_from_normal_matrix() and compute_from_factors(). n × n, row-major; the upper triangle.
  /// @param n at least 1
  double* normal_matrix(int n);
  /// @return the smallest singular value of A. Spoils normal(). Allocates nothing.
  double compute_from_normal_matrix();
  /// The same in a fraction of the time, of matrices that change little from one call to the next: inverse iteration from the last
  /// one's vector finds an upper bound; the pivots of AᵀA, shifted by the square of a value 2e-9 smaller, prove that there is no
  /// smaller one. Leaves normal() as it is. Allocates nothing. Where it fails the next calls are not tried, twice as many each time.
  /// @param factors of A, with its rows and columns in any order
  /// @return nothing where that cannot be told: slow convergence, equal singular values, a value so small that squares hide it
  std::optional<double> compute_from_factors(BlockTriangular& factors);

 private:
  void tridiagonalise();
  bool is_below_spectrum(double value);

  int n_ = 0;
  std::vector<double> matrix_, diagonal_, off_diagonal_, vector_, image_;
  std::vector<double> shifted_;
  std::vector<double> guess_;  ///< right singular vector of the smallest value, of length one
  int skipped_ = 0,
      backoff_ = 0;  ///< calls of compute_from_factors() that are not tried: left of the last pause, in that pause
};

/// The smallest singular value of a large sparse matrix: Lanczos' method on (AᵀA)⁻¹ from one and the same generic vector, with every
/// new vector made orthogonal to all before it, to 1e-10 of the value (Parlett, ch. 13).
/// @param matrix factorised and regular
/// @return nothing if it has not converged
std::optional<double> min_singular_value_by_lanczos(BlockTriangular& matrix);

/// @param n columns of A
/// @param inverse x := (AᵀA)⁻¹ x
/// @param steps at least so many, unless they can find nothing more
std::optional<double> min_singular_value_by_lanczos(int n, const std::function<void(VectorX&)>& inverse, int steps);

}  // namespace balance
