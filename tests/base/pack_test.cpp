#include "balance/foundation/base/pack.hpp"
#include "balance/foundation/base/types.hpp"

#include <doctest/doctest.h>

#include <random>

using namespace balance;

TEST_CASE_TEMPLATE("every operation on a pack is the same operation on each of its numbers", P, Pack<2>, Pack<4>,
                   Pack<8>) {
  const double values[] = {0.0, -0.0, 1.5, -2.25, 1e308, -1e-308, INFINITY, -INFINITY, NAN, 3.0};
  std::mt19937 random(1);
  const auto same = [](double a, double b) {
    return std::memcmp(&a, &b, sizeof a) == 0 || (std::isnan(a) && std::isnan(b));
  };
  for (int round = 0; round < 300; ++round) {
    double a[P::lanes], b[P::lanes];
    for (int l = 0; l < P::lanes; ++l) a[l] = values[random() % 10], b[l] = values[random() % 10];
    const P x = P::load(a), y = P::load(b);
    for (int l = 0; l < P::lanes; ++l) {
      CHECK(same((x + y)[l], a[l] + b[l]));
      CHECK(same((x - y)[l], a[l] - b[l]));
      CHECK(same((x * y)[l], a[l] * b[l]));
      CHECK(same((x / y)[l], a[l] / b[l]));
      CHECK(same((2 * x)[l], 2 * a[l]));
      CHECK(same((-x)[l], -a[l]));
      CHECK(same(abs(x)[l], std::abs(a[l])));
      CHECK(same(sqrt(x)[l], std::sqrt(a[l])));
      CHECK(same(min(x, y)[l], std::min(a[l], b[l])));
      CHECK(same(max(x, y)[l], std::max(a[l], b[l])));
      CHECK((x < y)[l] == (a[l] < b[l]));
      CHECK((x <= y)[l] == (a[l] <= b[l]));
      CHECK((x > y)[l] == (a[l] > b[l]));
      CHECK((x >= y)[l] == (a[l] >= b[l]));
      CHECK((x == y)[l] == (a[l] == b[l]));
      CHECK((x != y)[l] == (a[l] != b[l]));
      CHECK(same(select(x < y, x, y)[l], a[l] < b[l] ? a[l] : b[l]));
    }
  }
}

TEST_CASE("any and all ask every lane") {
  for (int truths = 0; truths < 16; ++truths) {
    double x[4];
    for (int l = 0; l < 4; ++l) x[l] = truths >> l & 1 ? 1 : -1;
    const Mask<4> positive = Pack<4>::load(x) > 0;
    CHECK(any(positive) == (truths != 0));
    CHECK(all(positive) == (truths == 15));
    CHECK(any(!positive) == (truths != 15));
  }
}

TEST_CASE("packs are scalars of small matrices, beside numbers that all lanes share") {
  using P = Pack<4>;
  const Eigen::Matrix3d R = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  Eigen::Matrix<P, 3, 1> v;
  double numbers[3][4];
  for (int i = 0; i < 3; ++i) {
    for (int l = 0; l < 4; ++l) numbers[i][l] = 1.0 / (i + l + 1);
    v[i] = P::load(numbers[i]);
  }
  const Eigen::Matrix<P, 3, 1> turned = R * v, there = R.cast<P>() * v, sum = 2.0 * v + turned.cross(v);
  for (int l = 0; l < 4; ++l) {
    const Eigen::Vector3d one(numbers[0][l], numbers[1][l], numbers[2][l]), expected = R * one;
    const Eigen::Vector3d expected_sum = 2 * one + expected.cross(one);
    for (int i = 0; i < 3; ++i) {
      // the order of the sums may differ
      CHECK(std::abs(turned[i][l] - expected[i]) <= 1e-15);
      CHECK(std::abs(there[i][l] - expected[i]) <= 1e-15);
      CHECK(std::abs(sum[i][l] - expected_sum[i]) <= 1e-15);
    }
  }
}
