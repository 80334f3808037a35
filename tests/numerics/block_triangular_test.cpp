#include "../sampling.hpp"
#include "patterns.hpp"

#include "balance/foundation/numerics/block_triangular.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <random>
#include <vector>

using namespace balance;
using namespace balance::numerics;

namespace {

/// A random sparse matrix that is regular for almost all values: a permutation with random entries beside it.
struct Sparse {
  Eigen::MatrixXi pattern;
  MatrixX values;
};

Sparse random_sparse(int n, double density, std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(0, 1), entry(-1, 1);
  Eigen::PermutationMatrix<Eigen::Dynamic> shuffle(n);
  shuffle.setIdentity();
  std::shuffle(shuffle.indices().data(), shuffle.indices().data() + n, random);
  Sparse out{Eigen::MatrixXi::Zero(n, n), MatrixX::Zero(n, n)};
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      if (shuffle.indices()[i] == j || unit(random) < density) out.pattern(i, j) = 1, out.values(i, j) = entry(random);
  return out;
}

BlockTriangular filled(const Sparse& sparse) {
  BlockTriangular solver;
  REQUIRE(solver.analyse(places(sparse.pattern)));
  for (int i = 0; i < sparse.pattern.rows(); ++i)
    for (int j = 0; j < sparse.pattern.cols(); ++j)
      if (sparse.pattern(i, j)) solver.at(i, j) = sparse.values(i, j);
  return solver;
}

}  // namespace

TEST_CASE("block triangular solutions are those of the dense matrix, transposed ones too") {
  std::mt19937_64 random(1);
  for (int trial = 0; trial < 300; ++trial) {
    const int n = 1 + trial % 12;
    const Sparse sparse = random_sparse(n, trial % 3 * 0.2, random);
    const Eigen::FullPivLU<MatrixX> dense(sparse.values);
    if (dense.rcond() < 1e-6) continue;
    BlockTriangular solver = filled(sparse);
    REQUIRE(solver.factorise() > 0);
    const VectorX b = VectorX::Random(n), c = VectorX::Random(n);
    VectorX x = b, pair_x = b, pair_z = c, transposed = b;
    solver.solve(x.data());
    solver.solve_pair(pair_x.data(), pair_z.data());
    solver.solve_transposed(transposed.data());
    const double tolerance = 1e-14 * n / dense.rcond();  // round-off times the condition number
    CHECK((sparse.values * x - b).norm() < tolerance);
    CHECK((sparse.values * pair_z - c).norm() < tolerance);
    CHECK((sparse.values.transpose() * transposed - b).norm() < tolerance);
    CHECK((pair_x - x).norm() <= 1e-15 * x.norm() / dense.rcond());
  }
}

TEST_CASE(
    "entries outside the pattern are zero, the normal matrix has the same eigenvalues, a chain of blocks stores what "
    "is not zero") {
  std::mt19937_64 random(2);
  for (int trial = 0; trial < 100; ++trial) {
    const Sparse sparse = random_sparse(1 + trial % 15, 0.15, random);
    const BlockTriangular solver = filled(sparse);
    const int n = solver.size();
    Samples normal(n, n);
    solver.write_normal_matrix(normal.data());
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) CHECK(solver.at(i, j) == sparse.values(i, j));
    const MatrixX whole = MatrixX(normal) + MatrixX(normal.triangularView<Eigen::StrictlyUpper>()).transpose();
    const VectorX found = Eigen::SelfAdjointEigenSolver<MatrixX>(whole).eigenvalues();
    const VectorX expected =
        Eigen::SelfAdjointEigenSolver<MatrixX>(sparse.values.transpose() * sparse.values).eigenvalues();
    CHECK((found - expected).cwiseAbs().maxCoeff() <= 1e-13 * expected.maxCoeff());
  }
  // a row needs the pair before it: dense the whole would take gigabytes
  const int pairs = sampling::is_whole() ? 20000 : 2000;
  SparsityPattern pattern;
  for (int k = 0; k < pairs; ++k)
    for (int side = 0; side < 2; ++side) {
      pattern.push_back({2 * k, 2 * k + 1});
      if (k > 0) pattern.back().insert(pattern.back().begin(), {2 * k - 2, 2 * k - 1});
    }
  BlockTriangular solver;
  REQUIRE(solver.analyse(pattern));
  CHECK(solver.entry_count() == 4u * pairs + 4u * (pairs - 1));
}

TEST_CASE("a pattern that no values make regular is refused, a singular matrix is noticed") {
  Eigen::MatrixXi pattern = Eigen::MatrixXi::Ones(3, 3);
  pattern.row(1).setZero();
  BlockTriangular solver;
  CHECK_FALSE(solver.analyse(places(pattern)));
  for (const int n : {1, 2, 3, 4, 7}) {
    REQUIRE(solver.analyse(places(Eigen::MatrixXi::Ones(n, n))));
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) solver.at(i, j) = i == n - 1 ? 0 : i + 2 * j + i * i * j;
    CHECK(solver.factorise() == 0);
  }
}

TEST_CASE("a way on which singular values cross zero is not near, however many cross at once in one block (A1)") {
  std::mt19937_64 random(3);
  for (int trial = 0; trial < 400; ++trial) {
    const int n = 2 + trial % 8, crossing = trial % 3;
    const Eigen::HouseholderQR<MatrixX> left(MatrixX::Random(n, n)), right(MatrixX::Random(n, n));
    const MatrixX U = left.householderQ(), V = right.householderQ();
    VectorX before = VectorX::Ones(n), after = VectorX::Ones(n);
    for (int k = 0; k < std::min(crossing, n); ++k) before[k] = 0.01 + 0.002 * k, after[k] = -0.02;
    BlockTriangular solver = filled({Eigen::MatrixXi::Ones(n, n), U * before.asDiagonal() * V.transpose()});
    REQUIRE(solver.factorise() > 0);
    solver.store();
    CHECK(solver.is_near_stored(0));  // nothing has changed
    const MatrixX now = U * after.asDiagonal() * V.transpose();
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) solver.at(i, j) = now(i, j);
    REQUIRE(solver.factorise() > 0);
    CHECK(solver.is_near_stored(0.99) == (crossing == 0));
  }
}

TEST_CASE("whatever counts as near has no singular matrix on the straight way") {
  std::mt19937_64 random(4);
  int near = 0;
  for (int trial = 0; trial < 600; ++trial) {
    const int n = 1 + trial % 7;
    const Sparse from = random_sparse(n, 0.5, random);
    BlockTriangular solver = filled(from);
    if (!(solver.factorise() > 1e-3)) continue;
    solver.store();
    const MatrixX to = from.values + 0.3 * MatrixX::Random(n, n).cwiseProduct(from.pattern.cast<double>());
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
        if (from.pattern(i, j)) solver.at(i, j) = to(i, j);
    if (!(solver.factorise() > 1e-3) || !solver.is_near_stored(0.9)) continue;
    ++near;
    for (int k = 0; k <= 50; ++k) {
      const MatrixX between = from.values + k / 50.0 * (to - from.values);
      CHECK(between.determinant() * to.determinant() > 0);
    }
  }
  CHECK(near > 50);
}
