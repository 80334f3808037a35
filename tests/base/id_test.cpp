// Indices of different kinds keep apart.

#include "balance/mechanics/model/mechanism.hpp"

#include <doctest/doctest.h>

#include <concepts>
#include <vector>

using namespace balance;

namespace {

template <class A, class B>
concept comparable = requires(A a, B b) {
  a == b;
};
template <class A, class B>
concept ordered = requires(A a, B b) {
  a < b;
};

static_assert(std::convertible_to<int, BodyId> && std::convertible_to<BodyId, int>);
static_assert(!std::convertible_to<JointId, BodyId> && !std::constructible_from<BodyId, JointId>);
static_assert(!std::assignable_from<BodyId&, CoordinateId>);
static_assert(comparable<BodyId, BodyId> && comparable<BodyId, int> && !comparable<BodyId, JointId>);
static_assert(ordered<BodyId, BodyId> && ordered<int, BodyId> && !ordered<BodyId, JointId>);

}  // namespace

TEST_CASE("an index finds its element in lists, vectors and matrices") {
  const std::vector<double> list{1, 2, 3};
  Eigen::Matrix2d matrix;
  matrix << 1, 2, 3, 4;
  BodyId body = 1;
  CHECK(list[body] == 2);
  CHECK(matrix(body, 0) == 3);
  CHECK(Eigen::Vector2d(matrix.col(body))[body] == 4);
  matrix(0, body) = 5;
  CHECK(matrix(0, 1) == 5);
  body += 1;
  CHECK(list[body] == 3);
  CHECK(++body == 3);
}
