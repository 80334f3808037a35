#pragma once
/// Factorizations of the library's dense matrices, compiled once: each takes the compiler seconds. Those of
/// right_singular_vectors.cpp are needed by conditions, design and control alone.
///
/// Eigen's own look for the largest entry first and read memory that is not there if there is none. The classes here know matrices
/// without rows or columns: rank 0, no values, any orthonormal vectors, and the solution 0. Of all others they give Eigen's digits.

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

namespace balance {

/// A = U Σ Vᵀ, values in decreasing order; those of a matrix that is not finite are NaN.
class SingularValueDecomposition : public Eigen::JacobiSVD<MatrixX> {
 public:
  SingularValueDecomposition() = default;
  /// @param vectors Eigen::ComputeThinU and so on; none are computed without
  explicit SingularValueDecomposition(const MatrixX& matrix, unsigned vectors = 0) { compute(matrix, vectors); }
  SingularValueDecomposition& compute(const MatrixX& matrix, unsigned vectors = 0);
};

/// As many as the smaller side has, in decreasing order.
VectorX singular_values(const MatrixX& matrix);

/// A P = Q R, the largest column that is left first.
class ColumnPivotingQr : public Eigen::ColPivHouseholderQR<MatrixX> {
 public:
  ColumnPivotingQr() = default;
  explicit ColumnPivotingQr(const MatrixX& matrix) { compute(matrix); }
  /// Keeps the other's threshold.
  explicit ColumnPivotingQr(const Eigen::ColPivHouseholderQR<MatrixX>& other)
      : Eigen::ColPivHouseholderQR<MatrixX>(other) {}
  ColumnPivotingQr& compute(const MatrixX& matrix);
};

/// Solutions of least norm of A x ≈ b, whatever the rank.
class CompleteOrthogonalDecomposition : public Eigen::CompleteOrthogonalDecomposition<MatrixX> {
 public:
  CompleteOrthogonalDecomposition() = default;
  explicit CompleteOrthogonalDecomposition(const MatrixX& matrix) { compute(matrix); }
  CompleteOrthogonalDecomposition& compute(const MatrixX& matrix);
};

/// Of a symmetric matrix, eigenvalues in increasing order.
class SymmetricEigenSolver : public Eigen::SelfAdjointEigenSolver<MatrixX> {
 public:
  SymmetricEigenSolver() = default;
  /// @param vectors Eigen::ComputeEigenvectors or Eigen::EigenvaluesOnly
  explicit SymmetricEigenSolver(const MatrixX& matrix, int vectors = Eigen::ComputeEigenvectors) {
    compute(matrix, vectors);
  }
  SymmetricEigenSolver& compute(const MatrixX& matrix, int vectors = Eigen::ComputeEigenvectors);
};

}  // namespace balance
