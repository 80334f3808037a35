#pragma once
/// The smallest singular value of a matrix, for thousands of small ones. Private to the library.

#include "balance/base/block_triangular.hpp"
#include "balance/base/types.hpp"

#include <optional>
#include <vector>

namespace balance {

/// Householder's tridiagonal form of AᵀA, then Laguerre's iteration for its smallest eigenvalue: from below, without ever passing it,
/// each step cubing the error of a simple one (B. N. Parlett, The Symmetric Eigenvalue Problem, 1998, ch. 7; J. H. Wilkinson, The Algebraic
/// Eigenvalue Problem, 1965, ch. 7). Values below 1e-8 of the largest are round-off.
class LeastSingular {
 public:
  /// Room for AᵀA, to be filled before of_normal(). n × n, row-major; both triangles.
  /// @param n at least 1
  double* normal(int n);
  /// @return the smallest singular value of A. Spoils normal(). Allocates nothing.
  double of_normal();

 private:
  void reduce();

  int n_ = 0;
  std::vector<double> matrix_, diagonal_, beside_, vector_, image_;
};

/// The smallest singular value of a large sparse matrix: Lanczos' method on (AᵀA)⁻¹ from one and the same generic vector, with every
/// new vector made orthogonal to all before it, to 1e-10 of the value (Parlett, ch. 13).
/// @param matrix factorised and regular
/// @return nothing if it has not converged
std::optional<double> least_singular_by_inverse(BlockTriangular& matrix);

}  // namespace balance
