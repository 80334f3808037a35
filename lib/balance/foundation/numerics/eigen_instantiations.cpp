#include "balance/foundation/numerics/eigen_instantiations.hpp"

template class Eigen::ColPivHouseholderQR<balance::MatrixX>;
template class Eigen::CompleteOrthogonalDecomposition<balance::MatrixX>;
template class Eigen::FullPivLU<balance::MatrixX>;
template class Eigen::HouseholderQR<balance::MatrixX>;
template class Eigen::LLT<balance::MatrixX>;
template class Eigen::PartialPivLU<balance::MatrixX>;
template class Eigen::SelfAdjointEigenSolver<balance::Matrix3>;
template class Eigen::SelfAdjointEigenSolver<balance::MatrixX>;

namespace balance::numerics {

ColumnPivotingQr& ColumnPivotingQr::compute(const MatrixX& matrix) {
  if (matrix.cols() > 0) {
    Eigen::ColPivHouseholderQR<MatrixX>::compute(matrix);
    return *this;
  }
  m_qr = matrix;
  m_hCoeffs.resize(0);
  m_temp.resize(0);
  m_colsTranspositions.resize(0);
  m_colNormsUpdated.resize(0);
  m_colNormsDirect.resize(0);
  m_colsPermutation.resize(0);
  m_nonzero_pivots = 0;
  m_maxpivot = 0;
  m_det_pq = 1;
  m_isInitialized = true;
  return *this;
}

CompleteOrthogonalDecomposition& CompleteOrthogonalDecomposition::compute(const MatrixX& matrix) {
  if (matrix.cols() > 0) {
    Eigen::CompleteOrthogonalDecomposition<MatrixX>::compute(matrix);
    return *this;
  }
  m_cpqr = ColumnPivotingQr(m_cpqr).compute(matrix);
  m_zCoeffs.resize(0);
  m_temp.resize(0);
  return *this;
}

SymmetricEigenSolver& SymmetricEigenSolver::compute(const MatrixX& matrix, int vectors) {
  if (matrix.size() > 0) {
    Eigen::SelfAdjointEigenSolver<MatrixX>::compute(matrix, vectors);
    return *this;
  }
  m_eivec.resize(0, 0);
  m_eivalues.resize(0);
  m_info = Eigen::Success;
  m_isInitialized = true;
  m_eigenvectorsOk = vectors == Eigen::ComputeEigenvectors;
  return *this;
}

}  // namespace balance::numerics
