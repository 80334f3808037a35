#include "balance/foundation/numerics/overdetermined_system.hpp"

#include <doctest/doctest.h>

#include <random>

using namespace balance;
using namespace balance::numerics;

TEST_CASE("a way on which singular values cross zero loses rank, however many cross at once, and no other does (A1)") {
  std::srand(5);
  for (int trial = 0; trial < 300; ++trial) {
    const int columns = 2 + trial % 7, more = trial % 3, crossing = trial % 4;
    const Eigen::HouseholderQR<MatrixX> left(MatrixX::Random(columns + more, columns + more)),
        right(MatrixX::Random(columns, columns));
    const MatrixX U = MatrixX(left.householderQ()).leftCols(columns), V = right.householderQ();
    VectorX before = VectorX::Ones(columns), after = VectorX::Constant(columns, 0.8);
    for (int k = 0; k < std::min(crossing, columns); ++k) before[k] = 0.1, after[k] = -0.2;
    RankMonitor watched;
    watched.factorise(U * before.asDiagonal() * V.transpose());
    CHECK_FALSE([&] {
      watched.store();
      return watched.loses_rank_since_stored();
    }());
    watched.factorise(U * after.asDiagonal() * V.transpose());
    CHECK(watched.loses_rank_since_stored() == (crossing > 0));
  }
}

TEST_CASE("turning by a right angle is far, but no loss of rank") {
  MatrixX kept = MatrixX::Identity(2, 2), now(2, 2);
  now << 0, -1, 1, 0;
  RankMonitor watched;
  watched.factorise(kept);
  watched.store();
  watched.factorise(now);
  CHECK_FALSE(watched.is_near_stored(0.99));
  CHECK_FALSE(watched.loses_rank_since_stored());
}
