// Distance of the equations' matrix from a singular one.

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/engine_scalar.hpp"
#include "balance/mechanics/kinematics/kinematic_equations.hpp"

#include <cmath>
#include <optional>

namespace balance::kinematics {

namespace {

/// Singular vectors of the smallest singular value; needed only for dual numbers.
struct SmallestSingularVectors {
  VectorX left, right;
};

[[maybe_unused]] SmallestSingularVectors find_singular_vectors_by_svd(const MatrixX& matrix) {
  const numerics::SingularValueDecomposition svd(matrix, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const Eigen::Index last = svd.singularValues().size() - 1;
  return {svd.matrixU().col(last), svd.matrixV().col(last)};
}

/// Inverse iteration on existing factors. @return std::nullopt if it does not converge because two singular values are
/// close
[[maybe_unused]] std::optional<SmallestSingularVectors> find_singular_vectors_by_inverse_iteration(
    numerics::BlockTriangular& factors) {
  constexpr int max_inverse_iterations = 24;
  constexpr double vector_change_tolerance = 1e-13;
  const int n = factors.size();
  VectorX right = VectorX::LinSpaced(n, 1, 1.3).normalized(), left;
  for (int step = 0; step < max_inverse_iterations; ++step) {
    left = right;
    factors.solve_transposed(left.data());
    VectorX next = left;
    factors.solve(next.data());
    next.normalize();
    left.normalize();
    const double change = (next - right).norm();
    right = next;
    if (step >= 3 && change < vector_change_tolerance * std::sqrt(n)) return SmallestSingularVectors{left, right};
  }
  return std::nullopt;
}

}  // namespace

template <class S>
typename S::Scalar KinematicEquations<S>::min_singular_value() {
  if (columns() == 0) return 1;
  if constexpr (!std::is_same_v<T, double>) {  // dσ = uᵀ dA v
    std::optional<SmallestSingularVectors> vectors;
    // a new evaluation with duals changes only the derivatives, so that the factors of the values still hold
    if (!redundant_ && regularity_ > 0) vectors = find_singular_vectors_by_inverse_iteration(values_of(square_));
    if (!vectors) vectors = find_singular_vectors_by_svd(dense());
    T sigma = 0;
    for (int r = 0; r < rows(); ++r)
      for (int c = 0; c < columns(); ++c) sigma += vectors->left[r] * vectors->right[c] * entry(r, c);
    return sigma;
  } else {
    const int n = columns();
    if (!redundant_ && n > numerics::max_dense_columns && factorise())
      if (const std::optional<double> value = min_singular_value_by_lanczos(square_)) return *value;
    double* normal = min_singular_value_.normal_matrix(n);
    if (redundant_) {
      Eigen::Map<Samples>(normal, n, n).noalias() = overdetermined_.dense().transpose() * overdetermined_.dense();
      return min_singular_value_.compute_from_normal_matrix();
    }
    square_.write_normal_matrix(normal);  // in storage order, which does not change the singular values
    if (factorised_evaluation_ == evaluations_ && regularity_ > 0)
      if (const std::optional<double> value = min_singular_value_.compute_from_factors(square_)) return *value;
    return min_singular_value_.compute_from_normal_matrix();
  }
}

template <class S>
MatrixX KinematicEquations<S>::dense() const {
  MatrixX matrix(rows(), columns());
  for (int r = 0; r < rows(); ++r)
    for (int c = 0; c < columns(); ++c) matrix(r, c) = value_of(entry(r, c));
  return matrix;
}

template <class S>
double KinematicEquations<S>::distance_to_singularity() const {
  if (!redundant_ && columns() > numerics::max_dense_columns) {
    numerics::SquareSystem<T> factors = square_;
    if (factors.factorise() > 0)
      if (const std::optional<double> value = min_singular_value_by_lanczos(values_of(factors))) return *value;
  }
  return numerics::smallest_singular_value(dense());
}

template EngineScalar KinematicEquations<PlanarOf<EngineScalar>>::min_singular_value();
template EngineScalar KinematicEquations<SpatialOf<EngineScalar>>::min_singular_value();
template MatrixX KinematicEquations<PlanarOf<EngineScalar>>::dense() const;
template MatrixX KinematicEquations<SpatialOf<EngineScalar>>::dense() const;
template double KinematicEquations<PlanarOf<EngineScalar>>::distance_to_singularity() const;
template double KinematicEquations<SpatialOf<EngineScalar>>::distance_to_singularity() const;

}  // namespace balance::kinematics
