#include "balance/foundation/numerics/min_singular_value.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>

using namespace balance;

namespace {

double min_singular_value(const MatrixX& matrix) {
  numerics::MinSingularValue least;
  const auto n = matrix.cols();
  Eigen::Map<Samples>(least.normal_matrix(static_cast<int>(n)), n, n) = matrix.transpose() * matrix;
  return least.compute_from_normal_matrix();
}

}  // namespace

TEST_CASE("the smallest singular value is the one that singular value decomposition finds") {
  std::mt19937 random(7);
  std::normal_distribution<double> number;
  for (int n = 1; n <= 40; ++n)
    for (int more = 0; more <= 3; ++more) {
      const MatrixX matrix = MatrixX::NullaryExpr(n + more, n, [&] { return number(random); });
      const VectorX values = Eigen::JacobiSVD<MatrixX>(matrix).singularValues();
      // λ = σ² is known to the round-off of the largest one
      const double doubt = 1e-14 * n * values[0] * values[0] / values[n - 1];
      CAPTURE(n);
      CHECK(std::abs(min_singular_value(matrix) - values[n - 1]) <= doubt + 1e-13 * values[n - 1]);
    }
}

TEST_CASE("a large sparse matrix has the smallest singular value of the dense one") {
  std::mt19937 random(11);
  std::normal_distribution<double> number;
  const int n = 120;
  MatrixX matrix = MatrixX::Zero(n, n);  // a chain of pairs, each with its neighbours
  for (int i = 0; i < n; ++i)
    for (int j = std::max(0, i - 3); j <= std::min(n - 1, i + 1); ++j) matrix(i, j) = (i == j ? 3 : 0) + number(random);
  numerics::BlockTriangular sparse;
  numerics::SparsityPattern pattern(n);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      if (matrix(i, j) != 0) pattern[i].push_back(j);
  REQUIRE(sparse.analyse(pattern));
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      if (matrix(i, j) != 0) sparse.at(i, j) = matrix(i, j);
  REQUIRE(sparse.factorise() > 0);
  const std::optional<double> found = min_singular_value_by_lanczos(sparse);
  REQUIRE(found);
  CHECK(*found == doctest::Approx(Eigen::JacobiSVD<MatrixX>(matrix).singularValues()[n - 1]).epsilon(1e-9));
}

TEST_CASE("the smallest singular value of matrices that fall apart, of equal values and of singular ones") {
  CHECK(min_singular_value(MatrixX::Identity(6, 6)) == doctest::Approx(1).epsilon(1e-14));
  CHECK(min_singular_value(VectorX::LinSpaced(5, 3, 7).asDiagonal().toDenseMatrix()) ==
        doctest::Approx(3).epsilon(1e-14));
  CHECK(min_singular_value(MatrixX::Zero(4, 4)) == 0);
  MatrixX twice = MatrixX::Zero(4, 4);  // blocks [2 1; 1 2] with singular values 1 and 3
  twice.topLeftCorner(2, 2) << 2, 1, 1, 2;
  twice.bottomRightCorner(2, 2) = twice.topLeftCorner(2, 2);
  CHECK(min_singular_value(twice) == doctest::Approx(1).epsilon(1e-14));
  CHECK(min_singular_value(MatrixX::Ones(5, 5)) < 1e-7);
}

TEST_CASE(
    "the smallest singular value by the factors is the other one along a way, past places where two of them are "
    "equal") {
  std::mt19937 random(13);
  std::normal_distribution<double> number;
  for (int n = 1; n <= 12; ++n) {
    const auto generic = [&] { return MatrixX::NullaryExpr(n, n, [&] { return number(random); }); };
    const Eigen::HouseholderQR<MatrixX> left(generic()), right(generic());
    const MatrixX U = left.householderQ(), V = right.householderQ();
    numerics::SparsityPattern full(n);
    for (std::vector<int>& row : full)
      for (int j = 0; j < n; ++j) row.push_back(j);
    numerics::BlockTriangular sparse;
    REQUIRE(sparse.analyse(full));
    numerics::MinSingularValue search;
    for (int k = 0; k <= 400; ++k) {  // two values cross in the middle; the vectors do not change at all
      VectorX values = VectorX::LinSpaced(n, 1, 2);
      values[0] = 0.2 + 0.002 * k;
      values[n - 1] = 1.0 - 0.002 * k;
      const MatrixX matrix = U * values.asDiagonal() * V.transpose();
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) sparse.at(i, j) = matrix(i, j);
      REQUIRE(sparse.factorise() > 0);
      Samples::Map(search.normal_matrix(n), n, n) = matrix.transpose() * matrix;
      const std::optional<double> found = search.compute_from_factors(sparse);
      std::sort(values.begin(), values.end());
      if (n == 1 || k < 60) CHECK(found.has_value());  // the next one is twice as large: each step gains a digit
      CHECK(std::abs(found.value_or(values[0]) - values[0]) <= 2e-9 * values[0]);
    }
  }
}
