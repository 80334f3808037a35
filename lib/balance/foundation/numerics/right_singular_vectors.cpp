#include "balance/foundation/numerics/right_singular_vectors.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"

template class Eigen::BDCSVD<balance::MatrixX>;
template class Eigen::LDLT<balance::MatrixX>;

namespace balance::numerics {

namespace {

/// Whether the vectors are orthonormal and the matrix stretches them by the values, up to round-off.
bool is_accurate(const MatrixX& matrix, const RightSingularVectors& svd) {
  if (!svd.values.allFinite() || !svd.vectors.allFinite()) return false;
  const auto n = svd.values.size();
  const double tolerance = 1e-14 * static_cast<double>(matrix.rows() + matrix.cols());
  const MatrixX image = matrix * svd.vectors;
  const double largest = max_abs(image.colwise().norm());
  return max_abs(svd.vectors.transpose() * svd.vectors - MatrixX::Identity(n, n)) <= tolerance &&
         max_abs(image.colwise().norm().transpose() - svd.values) <= tolerance * largest;
}

}  // namespace

RightSingularVectors compute_right_singular_vectors(const MatrixX& matrix) {
  const Eigen::BDCSVD<MatrixX> fast(matrix, Eigen::ComputeThinV);
  RightSingularVectors result{fast.singularValues(), fast.matrixV()};
  if (fast.info() == Eigen::Success && is_accurate(matrix, result)) return result;
  const SingularValueDecomposition accurate(matrix, Eigen::ComputeThinU | Eigen::ComputeThinV);
  return {accurate.singularValues(), accurate.matrixV()};
}

}  // namespace balance::numerics
