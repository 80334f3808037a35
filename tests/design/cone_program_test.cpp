/// Cone programs, against closed forms, the optimality conditions themselves and linear programs solved by Clp.

#include "balance/foundation/numerics/cone_program.hpp"
#include "balance/foundation/numerics/linear_program.hpp"
#include "balance/synthesis/design/variable_classification.hpp"

#include <doctest/doctest.h>

#include <cmath>

namespace {

using namespace balance;
using namespace balance::numerics;
using namespace balance::design;

TEST_CASE("the scaling takes the multipliers to the scaled slacks, and its inverse undoes it") {
  const SecondOrderCone cone(2, {3, 1, 4});
  UniformRandom random(3);
  const VectorX s = random.sample_point(10) + 3 * cone.identity(), z = random.sample_point(10) + 3 * cone.identity(),
                v = random.sample_point(10);
  REQUIRE(cone.min_eigenvalue(s) > 0);
  REQUIRE(cone.min_eigenvalue(z) > 0);
  const NesterovToddScaling scaling(cone, s, z);
  CHECK((scaling.apply(z) - scaling.apply_inverse(s)).norm() < 1e-13 * s.norm());
  CHECK((scaling.apply(scaling.apply_inverse(v)) - v).norm() < 1e-13);
  CHECK((scaling.scale_rows_inverse(v).col(0) - scaling.apply_inverse(v)).norm() < 1e-14);
  CHECK((cone.jordan_product(s, cone.jordan_quotient(s, v)) - v).norm() < 1e-13);
}

TEST_CASE("the longest step ends on the cone's edge") {
  const SecondOrderCone cone(1, {3});
  const VectorX x = VectorX::Map(std::vector<double>{1, 2, 0.5, 0.5}.data(), 4);
  const VectorX d = VectorX::Map(std::vector<double>{-0.1, -1, 0.3, 0.2}.data(), 4);
  const double step = cone.max_step(x, d);
  CHECK(std::abs(cone.min_eigenvalue(x + step * d)) < 1e-13);
  CHECK(std::isinf(cone.max_step(x, cone.identity())));
}

TEST_CASE("a linear function on a ball is least where the ball's edge faces it") {
  // |x - a| <= r: c . a - r |c|
  const Vector3 a(1, -2, 0.5), c(0.3, 2, -1);
  ConeProgramBuilder rows(3);
  MatrixX matrix = MatrixX::Zero(4, 3);
  matrix.bottomRows(3).setIdentity();
  VectorX constant(4);
  constant << 0.7, -a;
  rows.add_cone(matrix, constant);
  const ConeSolution found = solve_cone_program(rows.build(c));
  REQUIRE(found.status == ConeStatus::optimal);
  CHECK(std::abs(found.primal_value - (c.dot(a) - 0.7 * c.norm())) < 1e-9);
  CHECK((found.x - (a - 0.7 * c.normalized())).norm() < 1e-5);  // a ball is flat to second order
  CHECK(found.dual_value <= found.primal_value + 1e-9);
}

/// min |A x - b| over -1 <= x <= 1, as a cone program in (x, t).
ConeProgram distance(const MatrixX& a, const VectorX& b) {
  const Eigen::Index n = a.cols();
  ConeProgramBuilder rows(n + 1);
  MatrixX matrix = MatrixX::Zero(a.rows() + 1, n + 1);
  matrix(0, n) = 1;
  matrix.bottomLeftCorner(a.rows(), n) = a;
  VectorX constant = VectorX::Zero(a.rows() + 1);
  constant.tail(a.rows()) = -b;
  MatrixX box = MatrixX::Zero(2 * n, n + 1);
  box.topLeftCorner(n, n).setIdentity();
  box.bottomLeftCorner(n, n) = -MatrixX::Identity(n, n);
  rows.add_inequalities(box, VectorX::Ones(2 * n));
  rows.add_cone(matrix, constant);
  return rows.build(VectorX::Unit(n + 1, n));
}

TEST_CASE("a least distance within bounds meets the conditions of optimality") {
  UniformRandom random(7);
  for (int trial = 0; trial < 20; ++trial) {
    const MatrixX a = random.sample_point(7 * 4).reshaped(7, 4);
    const VectorX b = 3 * random.sample_point(7);
    const ConeProgram program = distance(a, b);
    const ConeSolution found = solve_cone_program(program);
    REQUIRE(found.status == ConeStatus::optimal);
    CHECK(found.primal_value - found.dual_value < 1e-9);
    // second route: the slope of |A x - b| pushes against the bounds only
    const VectorX x = found.x.head(4), slope = a.transpose() * (a * x - b).normalized();
    CHECK(std::abs((a * x - b).norm() - found.primal_value) < 1e-9);
    for (Eigen::Index i = 0; i < 4; ++i) {
      const bool low = x[i]<-1 + 1e-6, high = x[i]> 1 - 1e-6;
      CHECK((low ? slope[i] > -1e-5 : high ? slope[i] < 1e-5 : std::abs(slope[i]) < 1e-5));
    }
  }
}

TEST_CASE("equations that can be met leave a distance at round-off") {
  UniformRandom random(11);
  const MatrixX a = random.sample_point(6 * 4).reshaped(6, 4);
  const VectorX x = 0.5 * random.sample_point(4);
  const ConeSolution found = solve_cone_program(distance(a, a * x));
  REQUIRE(found.status == ConeStatus::optimal);
  CHECK(found.primal_value < 1e-9);
  CHECK((found.x.head(4) - x).norm() < 1e-8);
}

TEST_CASE("without cones it is linear programming") {
  UniformRandom random(5);
  for (int trial = 0; trial < 10; ++trial) {
    const MatrixX a = random.sample_point(12 * 4).reshaped(12, 4);
    const VectorX cost = random.sample_point(4);
    ConeProgramBuilder rows(4);
    rows.add_inequalities(a, VectorX::Ones(12));
    rows.add_inequalities(MatrixX::Identity(4, 4), VectorX::Constant(4, 5));
    rows.add_inequalities(-MatrixX::Identity(4, 4), VectorX::Constant(4, 5));
    const ConeSolution found = solve_cone_program(rows.build(cost));
    LinearProgram program(4);
    program.lower.setConstant(-5);
    program.upper.setConstant(5);
    program.cost = cost;
    for (Eigen::Index k = 0; k < 12; ++k) program.add_row(-no_bound, a.row(k), 1);
    const LinearProgramSolution other = solve_linear_program(program);
    REQUIRE(found.status == ConeStatus::optimal);
    REQUIRE(other.status == LinearProgramStatus::optimal);
    CHECK(std::abs(found.primal_value - cost.dot(other.x)) < 1e-8);
  }
}

TEST_CASE("contradicting inequalities are not solved") {
  ConeProgramBuilder rows(1);
  rows.add_inequalities(VectorX::Ones(1), -1);
  rows.add_inequalities(-VectorX::Ones(1), -1);
  CHECK(solve_cone_program(rows.build(VectorX::Ones(1))).status == ConeStatus::failed);
}

}  // namespace
