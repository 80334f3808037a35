#pragma once
/// Factorisations of the library's dense matrices, compiled once because each takes the compiler seconds. Only
/// conditions, design and control need those of right_singular_vectors.cpp.
///
/// Eigen's own classes search for the largest entry first and read out of bounds if there is none. The classes here
/// accept matrices without rows or columns: rank 0, no values, any orthonormal vectors, and the solution 0. For all
/// other matrices they give Eigen's results to the last digit.

#include "balance/foundation/base/types.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>

extern template class Eigen::ColPivHouseholderQR<balance::MatrixX>;
extern template class Eigen::CompleteOrthogonalDecomposition<balance::MatrixX>;
extern template class Eigen::FullPivLU<balance::MatrixX>;
extern template class Eigen::HouseholderQR<balance::MatrixX>;
extern template class Eigen::JacobiSVD<balance::MatrixX>;
extern template class Eigen::LLT<balance::MatrixX>;
extern template class Eigen::PartialPivLU<balance::MatrixX>;
extern template class Eigen::SelfAdjointEigenSolver<balance::Matrix3>;
extern template class Eigen::SelfAdjointEigenSolver<balance::MatrixX>;

// foundation/numerics/right_singular_vectors.cpp
extern template class Eigen::BDCSVD<balance::MatrixX>;
extern template class Eigen::LDLT<balance::MatrixX>;

namespace balance::numerics {

/// A = U Σ Vᵀ, singular values in decreasing order; NaN if the matrix is not finite.
class SingularValueDecomposition : public Eigen::JacobiSVD<MatrixX> {
 public:
  SingularValueDecomposition() = default;
  /// @param vectors Eigen::ComputeThinU and so on; by default none are computed
  explicit SingularValueDecomposition(const MatrixX& matrix, unsigned vectors = 0) { compute(matrix, vectors); }
  SingularValueDecomposition& compute(const MatrixX& matrix, unsigned vectors = 0);
};

/// min(rows, columns) values, in decreasing order.
VectorX singular_values(const MatrixX& matrix);

/// A P = Q R, the largest remaining column first.
class ColumnPivotingQr : public Eigen::ColPivHouseholderQR<MatrixX> {
 public:
  ColumnPivotingQr() = default;
  explicit ColumnPivotingQr(const MatrixX& matrix) { compute(matrix); }
  /// Keeps the threshold of `other`.
  explicit ColumnPivotingQr(const Eigen::ColPivHouseholderQR<MatrixX>& other)
      : Eigen::ColPivHouseholderQR<MatrixX>(other) {}
  ColumnPivotingQr& compute(const MatrixX& matrix);
};

/// Minimum-norm least-squares solutions of A x ≈ b for any rank.
class CompleteOrthogonalDecomposition : public Eigen::CompleteOrthogonalDecomposition<MatrixX> {
 public:
  CompleteOrthogonalDecomposition() = default;
  explicit CompleteOrthogonalDecomposition(const MatrixX& matrix) { compute(matrix); }
  CompleteOrthogonalDecomposition& compute(const MatrixX& matrix);
};

/// Eigen-decomposition of a symmetric matrix, eigenvalues in increasing order.
class SymmetricEigenSolver : public Eigen::SelfAdjointEigenSolver<MatrixX> {
 public:
  SymmetricEigenSolver() = default;
  /// @param vectors Eigen::ComputeEigenvectors or Eigen::EigenvaluesOnly
  explicit SymmetricEigenSolver(const MatrixX& matrix, int vectors = Eigen::ComputeEigenvectors) {
    compute(matrix, vectors);
  }
  SymmetricEigenSolver& compute(const MatrixX& matrix, int vectors = Eigen::ComputeEigenvectors);
};

}  // namespace balance::numerics
