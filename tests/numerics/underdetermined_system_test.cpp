// Smallest solutions within bounds, against all vertices of their polyhedron.

#include "balance/foundation/numerics/underdetermined_system.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/random.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

using namespace balance;
using namespace balance::numerics;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

UnderdeterminedSystem random_system(UniformRandom& random, Eigen::Index rows, Eigen::Index columns) {
  UnderdeterminedSystem system;
  system.matrix = MatrixX(rows, columns);
  for (Eigen::Index i = 0; i < rows; ++i) system.matrix.row(i) = random.sample_point(columns);
  system.right_hand_side = random.sample_point(rows);
  system.lower = VectorX::Constant(columns, -infinity);
  system.upper = VectorX::Constant(columns, infinity);
  system.excess_scale = VectorX::Ones(columns);
  return system;
}

/// The least τ with A x = b and rows (x, τ) ≥ limits, by trying every set of as many active rows as there are unknowns.
double min_by_enumeration(const UnderdeterminedSystem& system, const MatrixX& rows, const VectorX& limits) {
  const Eigen::Index n = system.matrix.cols() + 1, equalities = system.matrix.rows(), chosen = n - equalities;
  double least = infinity;
  std::vector<bool> pick(static_cast<std::size_t>(rows.rows()), false);
  std::fill(pick.begin(), pick.begin() + chosen, true);
  do {
    MatrixX square = MatrixX::Zero(n, n);
    VectorX rhs(n);
    square.topLeftCorner(equalities, n - 1) = system.matrix;
    rhs.head(equalities) = system.right_hand_side;
    Eigen::Index row = equalities;
    for (Eigen::Index i = 0; i < rows.rows(); ++i)
      if (pick[static_cast<std::size_t>(i)]) square.row(row) = rows.row(i), rhs[row++] = limits[i];
    const Eigen::FullPivLU<MatrixX> lu(square);
    if (!lu.isInvertible()) continue;
    const VectorX x = lu.solve(rhs);
    if (((rows * x - limits).array() > -1e-9 * (1 + x.cwiseAbs().maxCoeff())).all()) least = std::min(least, x[n - 1]);
  } while (std::prev_permutation(pick.begin(), pick.end()));
  return least;
}

double min_peak_by_enumeration(const UnderdeterminedSystem& system) {
  const Eigen::Index n = system.matrix.cols();
  MatrixX rows = MatrixX::Ones(2 * n, n + 1);
  rows.topLeftCorner(n, n) = MatrixX::Identity(n, n);
  rows.bottomLeftCorner(n, n) = -MatrixX::Identity(n, n);
  return min_by_enumeration(system, rows, VectorX::Zero(2 * n));
}

double min_excess_by_enumeration(const UnderdeterminedSystem& system) {
  const Eigen::Index n = system.matrix.cols();
  MatrixX rows = MatrixX::Zero(2 * n, n + 1);
  rows.topLeftCorner(n, n) = MatrixX::Identity(n, n);
  rows.bottomLeftCorner(n, n) = -MatrixX::Identity(n, n);
  rows.col(n) << system.excess_scale, system.excess_scale;
  VectorX limits(2 * n);
  limits << system.lower, -system.upper;
  return std::max(0.0, min_by_enumeration(system, rows, limits));
}

double excess_of(const UnderdeterminedSystem& system, const VectorX& x) {
  double excess = 0;
  for (Eigen::Index i = 0; i < x.size(); ++i)
    excess = std::max(
        {excess, (system.lower[i] - x[i]) / system.excess_scale[i], (x[i] - system.upper[i]) / system.excess_scale[i]});
  return excess;
}

}  // namespace

TEST_CASE("without bounds the Euclidean solution is the pseudo-inverse's, and nothing is active") {
  UniformRandom random(1);
  for (int k = 0; k < 20; ++k) {
    const UnderdeterminedSystem system = random_system(random, 1 + k % 3, 3 + k % 4);
    const BoundedSolution solution = solve_bounded(system, SolutionNorm::euclidean);
    const VectorX expected = CompleteOrthogonalDecomposition(system.matrix).solve(system.right_hand_side);
    CHECK((solution.x - expected).norm() < 1e-12 * expected.norm());
    CHECK(solution.active.empty());
    CHECK(solution.excess == 0);
  }
}

TEST_CASE("the least peak is that of the best vertex, and of equal peaks the least norm is taken") {
  UniformRandom random(2);
  for (int k = 0; k < 30; ++k) {
    const UnderdeterminedSystem system = random_system(random, 1 + k % 3, 3 + k % 3);
    const BoundedSolution solution = solve_bounded(system, SolutionNorm::maximum);
    const double least = min_peak_by_enumeration(system);
    CHECK((system.matrix * solution.x - system.right_hand_side).norm() < 1e-11);
    CHECK(solution.peak == doctest::Approx(least).epsilon(1e-10));
    CHECK(solution.x.cwiseAbs().maxCoeff() == doctest::Approx(solution.peak).epsilon(1e-14));
  }
  // x₁ = 1 alone has the peak; x₂ + x₃ = 1 is shared
  UnderdeterminedSystem separate = random_system(random, 2, 3);
  separate.matrix << 1, 0, 0, 0, 1, 1;
  separate.right_hand_side << 1, 1;
  const BoundedSolution solution = solve_bounded(separate, SolutionNorm::maximum);
  CHECK((solution.x - Vector3(1, 0.5, 0.5)).norm() < 1e-14);
}

TEST_CASE("bounds hold where they can; otherwise the largest excess is the least possible") {
  UniformRandom random(3);
  int kept = 0, exceeded = 0;
  for (int k = 0; k < 40; ++k) {
    UnderdeterminedSystem system = random_system(random, 1 + k % 2, 3 + k % 3);
    const double limit = 0.2 + 0.2 * (k % 5);
    system.lower.setConstant(-limit);
    system.upper.setConstant(limit);
    system.lower[0] = 0.5 * limit;  // a preload
    system.excess_scale[1] = 2;
    for (const SolutionNorm norm : {SolutionNorm::euclidean, SolutionNorm::maximum}) {
      const BoundedSolution solution = solve_bounded(system, norm);
      const double least = min_excess_by_enumeration(system);
      CHECK((system.matrix * solution.x - system.right_hand_side).norm() < 1e-11 * (1 + solution.x.norm()));
      CHECK(std::abs(solution.excess - least) < 1e-9 * (1 + least));
      CHECK(std::abs(excess_of(system, solution.x) - least) < 1e-8 * (1 + least));
      ++(least > 1e-9 ? exceeded : kept);
    }
  }
  CHECK(kept > 10);
  CHECK(exceeded > 10);
}

TEST_CASE("within bounds no shorter solution exists: nor nearer along any direction of the null space") {
  UniformRandom random(4);
  for (int k = 0; k < 20; ++k) {
    UnderdeterminedSystem system = random_system(random, 2, 4 + k % 3);
    const BoundedSolution free = solve_bounded(system, SolutionNorm::euclidean);
    system.upper = VectorX::Constant(free.x.size(), 0.8 * free.peak);
    system.lower = -system.upper;
    const BoundedSolution bounded = solve_bounded(system, SolutionNorm::euclidean);
    if (bounded.excess > 0) continue;
    CHECK(!bounded.active.empty());
    const SingularValueDecomposition svd(system.matrix, Eigen::ComputeFullV);
    for (int trial = 0; trial < 50; ++trial) {
      const VectorX step = svd.matrixV().rightCols(free.x.size() - 2) * random.sample_point(free.x.size() - 2);
      const VectorX other = bounded.x + 1e-3 * step;
      if (excess_of(system, other) == 0) CHECK(other.norm() >= bounded.x.norm() * (1 - 1e-12));
    }
  }
}

TEST_CASE("solutions follow the right-hand side without jumps") {
  UniformRandom random(5);
  for (int k = 0; k < 10; ++k) {
    UnderdeterminedSystem system = random_system(random, 2, 5);
    system.upper.setConstant(0.4);
    system.lower.setConstant(-0.4);
    const VectorX from = random.sample_point(2), to = random.sample_point(2);
    for (const SolutionNorm norm : {SolutionNorm::euclidean, SolutionNorm::maximum}) {
      VectorX before;
      double largest_step = 0, size = 0;
      constexpr int steps = 400;
      for (int i = 0; i <= steps; ++i) {
        system.right_hand_side = from + (to - from) * i / steps;
        const VectorX x = solve_bounded(system, norm).x;
        if (i > 0) largest_step = std::max(largest_step, (x - before).norm());
        size = std::max(size, x.norm());
        before = x;
      }
      // a Lipschitz constant: the largest multiple of the mean step that a polyhedron of these sizes makes
      CHECK(largest_step < 0.1 * size);
    }
  }
}

TEST_CASE("a component outside the null space is determined, whatever its bounds") {
  UnderdeterminedSystem system;
  system.matrix = MatrixX::Zero(2, 3);
  system.matrix << 1, 0, 0, 0, 1, -1;
  system.right_hand_side = Vector2(2, 0);
  system.lower = Vector3(-1, 0.5, -infinity);
  system.upper = Vector3(1, infinity, infinity);
  system.excess_scale = VectorX::Ones(3);
  const BoundedSolution solution = solve_bounded(system, SolutionNorm::euclidean);
  CHECK(solution.excess == doctest::Approx(1));
  CHECK(solution.x[0] == doctest::Approx(2));
  CHECK(solution.x[1] == doctest::Approx(solution.x[2]));
}
