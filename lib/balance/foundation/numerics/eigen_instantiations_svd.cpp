#include "balance/foundation/numerics/eigen_instantiations.hpp"

#include <limits>

template class Eigen::JacobiSVD<balance::MatrixX>;

namespace balance::numerics {

SingularValueDecomposition& SingularValueDecomposition::compute(const MatrixX& matrix, unsigned vectors) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  if (matrix.size() > 0) {
    Eigen::JacobiSVD<MatrixX>::compute(matrix, vectors);
    if (info() == Eigen::InvalidInput) {  // Eigen leaves them unset
      m_nonzeroSingularValues = 0;
      m_singularValues.setConstant(nan);
      m_matrixU.setConstant(nan);
      m_matrixV.setConstant(nan);
    }
    return *this;
  }
  Eigen::SVDBase<Eigen::JacobiSVD<MatrixX>>::allocate(matrix.rows(), matrix.cols(), vectors);
  m_matrixU.setIdentity();
  m_matrixV.setIdentity();
  m_nonzeroSingularValues = 0;
  m_isInitialized = true;
  return *this;
}

VectorX singular_values(const MatrixX& matrix) { return SingularValueDecomposition(matrix).singularValues(); }

}  // namespace balance::numerics
