#include "balance/foundation/numerics/sparse_matrix.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"

#include <doctest/doctest.h>

#include <random>

using namespace balance;
using namespace balance::numerics;

namespace {

/// A band, one full row and one full column.
MatrixX arrow(int rows, int columns, std::mt19937& random) {
  std::normal_distribution<double> number;
  MatrixX matrix = MatrixX::Zero(rows, columns);
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < columns; ++j)
      if (std::abs(i - j) <= 2 || i == rows / 2 || j == 3) matrix(i, j) = number(random) + (i == j ? 4 : 0);
  return matrix;
}

}  // namespace

TEST_CASE("damped least squares of sparse matrices are those of dense ones, tall or wide") {
  std::mt19937 random(5);
  for (const auto& [rows, columns] : {std::pair{60, 60}, {50, 70}, {80, 55}}) {
    const MatrixX dense = arrow(rows, columns, random);
    const VectorX b = VectorX::Random(rows);
    for (const double shift : {1e-8, 1e-3, 10.0}) {
      const MatrixX normal = dense.transpose() * dense + shift * MatrixX::Identity(columns, columns);
      const VectorX x = solve_damped_least_squares(dense.sparseView(), b, shift);
      const VectorX gradient = dense.transpose() * b;
      // normal · x = gradient to the round-off of the terms
      CHECK((normal * x - gradient).norm() < 1e-12 * (normal.norm() * x.norm() + gradient.norm()));
    }
  }
}

TEST_CASE("the smallest singular value of a sparse matrix is that of the dense one, or is not reported") {
  std::mt19937 random(6);
  for (const auto& [rows, columns] : {std::pair{60, 60}, {50, 70}, {80, 55}}) {
    MatrixX dense = arrow(rows, columns, random);
    const int full = std::min(rows, columns);
    const VectorX values = Eigen::JacobiSVD<MatrixX>(dense).singularValues();
    const std::optional<double> found = min_singular_value(SparseMatrix(dense.sparseView()));
    REQUIRE(found);
    // squares are solved with: round-off of the largest, magnified by σ₁²/σₙ²
    const double doubt = 1e-9 + 1e-14 * std::pow(values[0] / values[full - 1], 2);
    CHECK(*found == doctest::Approx(values[full - 1]).epsilon(doubt));
    for (const double least : {1e-8, 1e-12, 0.0}) {  // of rank full − 1 but for so much
      const Eigen::JacobiSVD<MatrixX> svd(dense, Eigen::ComputeThinU | Eigen::ComputeThinV);
      VectorX changed = svd.singularValues();
      changed[full - 1] = least * changed[0];
      const MatrixX lost = svd.matrixU() * changed.asDiagonal() * svd.matrixV().transpose();
      CHECK_FALSE(min_singular_value(SparseMatrix(lost.sparseView())).has_value());
    }
  }
  CHECK_FALSE(min_singular_value(SparseMatrix(60, 60)).has_value());
}
