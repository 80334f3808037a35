/// Cone programs, against closed forms, the optimality conditions themselves and linear programs solved by Clp.

#include "balance/design/cone_program.hpp"
#include "balance/conditions/linear_program.hpp"
#include "balance/design/box.hpp"

#include <doctest/doctest.h>

#include <cmath>

namespace {

using namespace balance;
using namespace balance::designing;

TEST_CASE("the scaling takes the multipliers to the scaled slacks, and its inverse undoes it") {
  const SecondOrderCone cone(2, {3, 1, 4});
  RandomNumbers random(3);
  const VectorX s = random.point(10) + 3 * cone.unit(), z = random.point(10) + 3 * cone.unit(), v = random.point(10);
  REQUIRE(cone.margin(s) > 0);
  REQUIRE(cone.margin(z) > 0);
  const ConeScaling scaling(cone, s, z);
  CHECK((scaling.times(z) - scaling.inverse_times(s)).norm() < 1e-13 * s.norm());
  CHECK((scaling.times(scaling.inverse_times(v)) - v).norm() < 1e-13);
  CHECK((scaling.inverse_scaled(v).col(0) - scaling.inverse_times(v)).norm() < 1e-14);
  CHECK((cone.product(s, cone.quotient(s, v)) - v).norm() < 1e-13);
}

TEST_CASE("the longest step ends on the cone's edge") {
  const SecondOrderCone cone(1, {3});
  const VectorX x = VectorX::Map(std::vector<double>{1, 2, 0.5, 0.5}.data(), 4);
  const VectorX d = VectorX::Map(std::vector<double>{-0.1, -1, 0.3, 0.2}.data(), 4);
  const double step = cone.longest_step(x, d);
  CHECK(std::abs(cone.margin(x + step * d)) < 1e-13);
  CHECK(std::isinf(cone.longest_step(x, cone.unit())));
}

TEST_CASE("a linear function on a ball is least where the ball's edge faces it") {
  // |x - a| <= r: c . a - r |c|
  const Vector3 a(1, -2, 0.5), c(0.3, 2, -1);
  ConeRows rows(3);
  MatrixX matrix = MatrixX::Zero(4, 3);
  matrix.bottomRows(3).setIdentity();
  VectorX constant(4);
  constant << 0.7, -a;
  rows.in_cone(matrix, constant);
  const ConeSolution found = minimise(rows.finish(c));
  REQUIRE(found.status == ConeStatus::solved);
  CHECK(std::abs(found.value - (c.dot(a) - 0.7 * c.norm())) < 1e-9);
  CHECK((found.x - (a - 0.7 * c.normalized())).norm() < 1e-5);  // a ball is flat to second order
  CHECK(found.bound <= found.value + 1e-9);
}

/// min |A x - b| over -1 <= x <= 1, as a cone program in (x, t).
ConeProgram distance(const MatrixX& a, const VectorX& b) {
  const Eigen::Index n = a.cols();
  ConeRows rows(n + 1);
  MatrixX matrix = MatrixX::Zero(a.rows() + 1, n + 1);
  matrix(0, n) = 1;
  matrix.bottomLeftCorner(a.rows(), n) = a;
  VectorX constant = VectorX::Zero(a.rows() + 1);
  constant.tail(a.rows()) = -b;
  MatrixX box = MatrixX::Zero(2 * n, n + 1);
  box.topLeftCorner(n, n).setIdentity();
  box.bottomLeftCorner(n, n) = -MatrixX::Identity(n, n);
  rows.at_most(box, VectorX::Ones(2 * n));
  rows.in_cone(matrix, constant);
  return rows.finish(VectorX::Unit(n + 1, n));
}

TEST_CASE("a least distance within bounds meets the conditions of optimality") {
  RandomNumbers random(7);
  for (int trial = 0; trial < 20; ++trial) {
    const MatrixX a = random.point(7 * 4).reshaped(7, 4);
    const VectorX b = 3 * random.point(7);
    const ConeProgram program = distance(a, b);
    const ConeSolution found = minimise(program);
    REQUIRE(found.status == ConeStatus::solved);
    CHECK(found.value - found.bound < 1e-9);
    // second route: the slope of |A x - b| pushes against the bounds only
    const VectorX x = found.x.head(4), slope = a.transpose() * (a * x - b).normalized();
    CHECK(std::abs((a * x - b).norm() - found.value) < 1e-9);
    for (Eigen::Index i = 0; i < 4; ++i) {
      const bool low = x[i]<-1 + 1e-6, high = x[i]> 1 - 1e-6;
      CHECK((low ? slope[i] > -1e-5 : high ? slope[i] < 1e-5 : std::abs(slope[i]) < 1e-5));
    }
  }
}

TEST_CASE("equations that can be met leave a distance at round-off") {
  RandomNumbers random(11);
  const MatrixX a = random.point(6 * 4).reshaped(6, 4);
  const VectorX x = 0.5 * random.point(4);
  const ConeSolution found = minimise(distance(a, a * x));
  REQUIRE(found.status == ConeStatus::solved);
  CHECK(found.value < 1e-9);
  CHECK((found.x.head(4) - x).norm() < 1e-8);
}

TEST_CASE("without cones it is linear programming") {
  RandomNumbers random(5);
  for (int trial = 0; trial < 10; ++trial) {
    const MatrixX a = random.point(12 * 4).reshaped(12, 4);
    const VectorX cost = random.point(4);
    ConeRows rows(4);
    rows.at_most(a, VectorX::Ones(12));
    rows.at_most(MatrixX::Identity(4, 4), VectorX::Constant(4, 5));
    rows.at_most(-MatrixX::Identity(4, 4), VectorX::Constant(4, 5));
    const ConeSolution found = minimise(rows.finish(cost));
    LinearProgram program(4);
    program.lower.setConstant(-5);
    program.upper.setConstant(5);
    program.cost = cost;
    for (Eigen::Index k = 0; k < 12; ++k) program.add_row(-unbounded, a.row(k), 1);
    const ProgramSolution other = minimize(program);
    REQUIRE(found.status == ConeStatus::solved);
    REQUIRE(other.status == ProgramStatus::solved);
    CHECK(std::abs(found.value - cost.dot(other.x)) < 1e-8);
  }
}

TEST_CASE("contradicting inequalities are not solved") {
  ConeRows rows(1);
  rows.at_most(VectorX::Ones(1), -1);
  rows.at_most(-VectorX::Ones(1), -1);
  CHECK(minimise(rows.finish(VectorX::Ones(1))).status == ConeStatus::unsolved);
}

}  // namespace
