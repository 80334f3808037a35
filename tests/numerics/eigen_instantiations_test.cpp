#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <vector>

using namespace balance;
using namespace balance::numerics;

namespace {

struct Shape {
  Eigen::Index rows, columns;
};
const std::vector<Shape> empty_shapes = {{0, 0}, {0, 1}, {0, 5}, {1, 0}, {5, 0}};
const std::vector<Shape> shapes = {{1, 1}, {1, 4}, {4, 1}, {3, 3}, {3, 7}, {7, 3}};

MatrixX random_matrix(const Shape& shape, std::mt19937& random) {
  std::normal_distribution<double> number;
  return MatrixX::NullaryExpr(shape.rows, shape.columns, [&] { return number(random); });
}

bool is_orthonormal(const MatrixX& vectors) {
  const MatrixX gram = vectors.transpose() * vectors;
  return max_abs(gram - MatrixX::Identity(gram.rows(), gram.cols())) < 1e-14;  // exact for the identity
}

}  // namespace

TEST_CASE("a matrix without entries has no singular values, full bases and the solution 0") {
  for (const Shape& shape : empty_shapes) {
    CAPTURE(shape.rows);
    CAPTURE(shape.columns);
    const MatrixX matrix(shape.rows, shape.columns);
    CHECK(singular_values(matrix).size() == 0);
    const SingularValueDecomposition full(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
    CHECK(full.rank() == 0);
    CHECK(full.matrixU().cols() == shape.rows);
    CHECK(is_orthonormal(full.matrixU()));
    CHECK(full.matrixV().cols() == shape.columns);
    CHECK(is_orthonormal(full.matrixV()));
    const SingularValueDecomposition thin(matrix, Eigen::ComputeThinU | Eigen::ComputeThinV);
    const VectorX right = VectorX::Ones(shape.rows), zero = VectorX::Zero(shape.columns);
    CHECK(thin.solve(right) == zero);
    const ColumnPivotingQr qr(matrix);
    CHECK(qr.rank() == 0);
    CHECK(qr.solve(right) == zero);
    const MatrixX q = qr.householderQ() * MatrixX::Identity(shape.rows, shape.rows);
    CHECK(q == MatrixX::Identity(shape.rows, shape.rows));
    const CompleteOrthogonalDecomposition least(matrix);
    CHECK(least.rank() == 0);
    CHECK(least.solve(right) == zero);
    CHECK(least.pseudoInverse().rows() == shape.columns);
  }
  CHECK(SymmetricEigenSolver(MatrixX(0, 0)).eigenvalues().size() == 0);
}

TEST_CASE("of a matrix with entries the decompositions have Eigen's digits, after one without entries as before it") {
  std::mt19937 random(3);
  SingularValueDecomposition svd;
  ColumnPivotingQr qr;
  CompleteOrthogonalDecomposition least;
  least.setThreshold(1e-9);
  for (const Shape& shape : shapes) {
    const MatrixX matrix = random_matrix(shape, random);
    const VectorX right = random_matrix({shape.rows, 1}, random);
    svd.compute(MatrixX(0, 3), Eigen::ComputeThinU | Eigen::ComputeThinV);
    svd.compute(matrix, Eigen::ComputeThinU | Eigen::ComputeThinV);
    const Eigen::JacobiSVD<MatrixX> own(matrix, Eigen::ComputeThinU | Eigen::ComputeThinV);
    CHECK(svd.singularValues() == own.singularValues());
    CHECK(svd.matrixU() == own.matrixU());
    CHECK(svd.matrixV() == own.matrixV());
    CHECK(singular_values(matrix) == Eigen::JacobiSVD<MatrixX>(matrix).singularValues());
    qr.compute(MatrixX(2, 0));
    qr.compute(matrix);
    CHECK(qr.matrixQR() == Eigen::ColPivHouseholderQR<MatrixX>(matrix).matrixQR());
    least.compute(MatrixX(2, 0));
    least.compute(matrix);
    Eigen::CompleteOrthogonalDecomposition<MatrixX> eigen;
    eigen.setThreshold(1e-9);
    CHECK(least.solve(right) == eigen.compute(matrix).solve(right));
    CHECK(least.threshold() == 1e-9);
    const MatrixX symmetric = matrix * matrix.transpose();
    CHECK(SymmetricEigenSolver(symmetric).eigenvalues() ==
          Eigen::SelfAdjointEigenSolver<MatrixX>(symmetric).eigenvalues());
  }
}

TEST_CASE("singular values of a matrix that is not finite are not numbers") {
  MatrixX matrix = MatrixX::Identity(3, 3);
  matrix(1, 2) = INFINITY;
  for (const double value : singular_values(matrix)) CHECK(value != value);
}

TEST_CASE("the largest absolute value of no entries is 0, their bounds are those of the empty set") {
  const VectorX none(0);
  CHECK(max_abs(none) == 0);
  CHECK(max_coefficient(none) == -INFINITY);
  CHECK(min_coefficient(none) == INFINITY);
  CHECK(row_maxima(MatrixX(2, 0)) == VectorX::Constant(2, -INFINITY));
  CHECK(row_maxima(MatrixX(0, 2)).size() == 0);
  CHECK_THROWS_AS(max_index(none), std::invalid_argument);
  CHECK_THROWS_AS(min_index(none), std::invalid_argument);
  std::mt19937 random(5);
  const MatrixX matrix = random_matrix({4, 6}, random);
  CHECK(max_abs(matrix) == matrix.cwiseAbs().maxCoeff());
  CHECK(max_coefficient(matrix.row(2)) == row_maxima(matrix)[2]);
  CHECK(matrix(2, max_index(matrix.row(2))) == max_coefficient(matrix.row(2)));
  CHECK(matrix(min_index(matrix.col(1)), 1) == min_coefficient(matrix.col(1)));
}
