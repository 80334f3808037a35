#include "balance/foundation/numerics/sparse_matrix.hpp"

#include "balance/foundation/numerics/extrema.hpp"
#include "balance/foundation/numerics/min_singular_value.hpp"

#include <Eigen/SparseCholesky>

#include <cmath>

namespace balance::numerics {

namespace {

/// Bound on the number of entries of AᵀA. @param entries per row of A
double bound_normal_entries(const Eigen::VectorXi& entries) { return entries.cast<double>().squaredNorm(); }

Eigen::VectorXi entries_per_row(const SparseMatrix& A) {
  Eigen::VectorXi count = Eigen::VectorXi::Zero(A.rows());
  for (Eigen::Index k = 0; k < A.nonZeros(); ++k) ++count[A.innerIndexPtr()[k]];
  return count;
}

Eigen::VectorXi entries_per_column(const SparseMatrix& A) {
  return Eigen::VectorXi::NullaryExpr(A.cols(),
                                      [&](Eigen::Index c) { return A.outerIndexPtr()[c + 1] - A.outerIndexPtr()[c]; });
}

SparseMatrix identity(Eigen::Index n) {
  SparseMatrix matrix(n, n);
  matrix.setIdentity();
  return matrix;
}

}  // namespace

VectorX solve_damped_least_squares(const SparseMatrix& A, const VectorX& b, double shift) {
  const bool use_row_form = bound_normal_entries(entries_per_column(A)) <= bound_normal_entries(entries_per_row(A));
  const SparseMatrix transposed = A.transpose();
  SparseMatrix normal = use_row_form ? SparseMatrix(A * transposed) : SparseMatrix(transposed * A);
  normal += shift * identity(normal.rows());
  const Eigen::SimplicialLDLT<SparseMatrix> factors(normal);
  if (use_row_form) return transposed * factors.solve(b);
  return factors.solve(transposed * b);
}

std::optional<double> min_singular_value(const SparseMatrix& A) {
  constexpr double min_relative_singular_value = 1e-6;
  constexpr int min_lanczos_steps = 20;  // an error by a factor of two then has a probability below 1e-12
  if (A.nonZeros() == 0) return {};
  const SparseMatrix transposed = A.transpose();
  const Eigen::SimplicialLDLT<SparseMatrix> factors(A.rows() <= A.cols() ? SparseMatrix(A * transposed)
                                                                         : SparseMatrix(transposed * A));
  if (factors.info() != Eigen::Success || !(min_coefficient(factors.vectorD()) > 0)) return {};
  const auto inverse = [&](VectorX& x) { x = factors.solve(x).eval(); };
  const std::optional<double> sigma_min =
      min_singular_value_by_lanczos(static_cast<int>(factors.rows()), inverse, min_lanczos_steps);
  return sigma_min && *sigma_min > min_relative_singular_value * A.norm() ? sigma_min : std::nullopt;
}

}  // namespace balance::numerics
