#include "patterns.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/lane_block_triangular.hpp"

#include <doctest/doctest.h>

#include <array>
#include <random>

using namespace balance;
using namespace balance::numerics;

namespace {

constexpr int eight = 8;

/// One regular matrix for each of eight samples, near to each other; sparse, so that it falls apart into blocks.
struct Samples8 {
  Eigen::MatrixXi pattern;
  std::array<MatrixX, eight> matrix;
};

Samples8 near_samples(int n, double density, double apart, std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(0, 1), entry(-1, 1);
  Samples8 out{Eigen::MatrixXi::Identity(n, n), {}};
  MatrixX middle = MatrixX::Zero(n, n);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      if (i == j || unit(random) < density) out.pattern(i, j) = 1, middle(i, j) = entry(random);
  for (MatrixX& one : out.matrix) {
    one = middle;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
        if (out.pattern(i, j)) one(i, j) += apart * entry(random);
  }
  return out;
}

BlockTriangular scalar_of(const Samples8& samples, int which) {
  BlockTriangular scalar;
  REQUIRE(scalar.analyse(places(samples.pattern)));
  for (int i = 0; i < samples.pattern.rows(); ++i)
    for (int j = 0; j < samples.pattern.cols(); ++j)
      if (samples.pattern(i, j)) scalar.at(i, j) = samples.matrix[which](i, j);
  scalar.factorise();
  return scalar;
}

struct Answers {
  std::array<double, eight> quality;
  std::array<VectorX, eight> solved, transposed;
};

/// All eight, as many at a time as a pack holds.
template <int W>
Answers solve_all(const Samples8& samples, const BlockTriangular& scalar, const VectorX& right) {
  const int n = static_cast<int>(right.size());
  Answers out;
  LaneBlockTriangular<Pack<W>> lanes(scalar);
  for (int first = 0; first < eight; first += W) {
    std::vector<Pack<W>> x(n), z(n);
    for (int i = 0; i < n; ++i) {
      x[i] = z[i] = right[i];
      for (int j = 0; j < n; ++j)
        if (samples.pattern(i, j))
          for (int l = 0; l < W; ++l) lanes.at(i, j).v[l] = samples.matrix[first + l](i, j);
    }
    const Pack<W> quality = lanes.factorise();
    lanes.solve(x.data());
    lanes.solve_transposed(z.data());
    for (int l = 0; l < W; ++l) {
      out.quality[first + l] = quality[l];
      out.solved[first + l] = out.transposed[first + l] = VectorX(n);
      for (int i = 0; i < n; ++i) out.solved[first + l][i] = x[i][l], out.transposed[first + l][i] = z[i][l];
    }
  }
  return out;
}

void check_right(const MatrixX& matrix, const VectorX& right, const Answers& answers, int lane) {
  const Eigen::FullPivLU<MatrixX> dense(matrix);
  if (dense.rcond() < 1e-6) return;
  // round-off times condition, and the growth that the order of pivots may cost
  const double tolerance = 1e-13 * static_cast<double>(right.size()) / dense.rcond();
  CHECK(answers.quality[lane] > 0);
  CHECK((matrix * answers.solved[lane] - right).norm() < tolerance);
  CHECK((matrix.transpose() * answers.transposed[lane] - right).norm() < tolerance);
}

void check_same(const Answers& a, const Answers& b, int lane) {
  CHECK(a.quality[lane] == b.quality[lane]);
  CHECK(a.solved[lane] == b.solved[lane]);
  CHECK(a.transposed[lane] == b.transposed[lane]);
}

}  // namespace

TEST_CASE("systems in lanes are solved like dense ones, whether the order of pivots suits a lane or not") {
  std::mt19937_64 random(1);
  for (int trial = 0; trial < 200; ++trial) {
    const int n = 1 + trial % 9;
    // near each other; strangers that share nothing but the pattern
    const Samples8 samples = near_samples(n, trial % 3 * 0.3, trial % 2 ? 0.01 : 1, random);
    const VectorX right = VectorX::Random(n);
    const Answers answers = solve_all<4>(samples, scalar_of(samples, 0), right);
    for (int lane = 0; lane < eight; ++lane) check_right(samples.matrix[lane], right, answers, lane);
  }
}

TEST_CASE("how many lanes there are changes no bit") {
  std::mt19937_64 random(2);
  for (int trial = 0; trial < 60; ++trial) {
    const int n = 1 + trial % 9;
    const Samples8 samples = near_samples(n, 0.7, trial % 2 ? 0.05 : 1, random);
    const VectorX right = VectorX::Random(n);
    const BlockTriangular scalar = scalar_of(samples, 0);
    const Answers two = solve_all<2>(samples, scalar, right), all = solve_all<8>(samples, scalar, right);
    for (int lane = 0; lane < eight; ++lane) check_same(two, all, lane);
  }
}

TEST_CASE("a lane without a regular matrix is reported, and its neighbours do not notice") {
  std::mt19937_64 random(3);
  for (const int n : {1, 2, 3, 4, 5, 6, 8}) {
    const Samples8 whole = near_samples(n, 1, 0.01, random);
    const VectorX right = VectorX::Random(n);
    const BlockTriangular scalar = scalar_of(whole, 0);
    const Answers undisturbed = solve_all<8>(whole, scalar, right);
    for (const double fault : {0.0, static_cast<double>(NAN), static_cast<double>(INFINITY)}) {
      Samples8 samples = whole;
      samples.matrix[3].row(n - 1).setConstant(fault);
      const Answers answers = solve_all<8>(samples, scalar, right);
      CAPTURE(n);
      CAPTURE(fault);
      CHECK(answers.quality[3] == 0);
      for (int lane = 0; lane < eight; ++lane)
        if (lane != 3) check_same(answers, undisturbed, lane);
    }
  }
}
