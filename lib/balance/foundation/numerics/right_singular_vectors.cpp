#include "balance/foundation/numerics/right_singular_vectors.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"

template class Eigen::BDCSVD<balance::MatrixX>;
template class Eigen::LDLT<balance::MatrixX>;

namespace balance {

namespace {

/// Orthonormal vectors that the matrix stretches by the values, up to round-off.
bool is_accurate(const MatrixX& matrix, const RightSingularVectors& found) {
  if (!found.values.allFinite() || !found.vectors.allFinite()) return false;
  const auto n = found.values.size();
  const double allowed = 1e-14 * static_cast<double>(matrix.rows() + matrix.cols());
  const MatrixX image = matrix * found.vectors;
  const double largest = max_abs(image.colwise().norm());
  return max_abs(found.vectors.transpose() * found.vectors - MatrixX::Identity(n, n)) <= allowed &&
         max_abs(image.colwise().norm().transpose() - found.values) <= allowed * largest;
}

}  // namespace

RightSingularVectors compute_right_singular_vectors(const MatrixX& matrix) {
  const Eigen::BDCSVD<MatrixX> fast(matrix, Eigen::ComputeThinV);
  RightSingularVectors found{fast.singularValues(), fast.matrixV()};
  if (fast.info() == Eigen::Success && is_accurate(matrix, found)) return found;
  const SingularValueDecomposition sure(matrix, Eigen::ComputeThinU | Eigen::ComputeThinV);
  return {sure.singularValues(), sure.matrixV()};
}

}  // namespace balance
