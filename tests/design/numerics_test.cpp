#include "balance/foundation/numerics/bounded_least_squares.hpp"
#include "balance/foundation/numerics/levenberg_marquardt.hpp"
#include "balance/foundation/numerics/quadratic_program.hpp"
#include "balance/synthesis/design/feature_map.hpp"

#include "mechanisms.hpp"

#include <doctest/doctest.h>

using namespace balance;
using namespace balance::numerics;
using namespace balance::design;

namespace {

MatrixX random_matrix(UniformRandom& random, Eigen::Index rows, Eigen::Index columns) {
  MatrixX m(rows, columns);
  for (Eigen::Index i = 0; i < rows; ++i)
    for (Eigen::Index j = 0; j < columns; ++j) m(i, j) = random(-1, 1);
  return m;
}

}  // namespace

TEST_CASE("bounded least squares leave a gradient that points out of the box wherever a bound is active") {
  UniformRandom random(3);
  for (int trial = 0; trial < 50; ++trial) {
    const MatrixX a = random_matrix(random, 9, 6);
    const VectorX b = 3 * random.sample_point(9), lower = VectorX::Constant(6, -0.5), upper = VectorX::Constant(6, 0.7);
    VectorX x = VectorX::Zero(6);
    bounded_least_squares(a, b, lower, upper, x);
    const VectorX gradient = a.transpose() * (a * x - b);
    for (Eigen::Index i = 0; i < 6; ++i) {
      REQUIRE(x[i] >= lower[i]);
      REQUIRE(x[i] <= upper[i]);
      // the Karush–Kuhn–Tucker conditions; 1e-12 is round-off of numbers of the order of ten
      if (x[i] > lower[i] && x[i] < upper[i]) CHECK(std::abs(gradient[i]) < 1e-12);
      if (x[i] == lower[i]) CHECK(gradient[i] > -1e-12);
      if (x[i] == upper[i]) CHECK(gradient[i] < 1e-12);
    }
  }
}

TEST_CASE("quadratic programs end where the multipliers say so") {
  UniformRandom random(5);
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::Index n = 6;
    const MatrixX root = random_matrix(random, n, n);
    QuadraticProgram p;
    p.hessian = root * root.transpose() + 0.1 * MatrixX::Identity(n, n);
    p.gradient = 3 * random.sample_point(6);
    p.equalities = random_matrix(random, 2, n);
    p.equalities.conservativeResize(3, n);
    p.equalities.row(2) = p.equalities.row(0) - 2 * p.equalities.row(1);  // follows from the others
    const VectorX inside = 0.3 * random.sample_point(6);
    p.equality_values = p.equalities * inside;
    p.inequalities = random_matrix(random, 10, n);
    p.inequality_lower_bounds = p.inequalities * inside - VectorX::Constant(10, 0.1);
    const auto optimum = solve_quadratic_program(p);
    REQUIRE(optimum);
    const VectorX slack = p.inequalities * optimum->x - p.inequality_lower_bounds;
    CHECK((p.equalities * optimum->x - p.equality_values).norm() < 1e-11);
    CHECK(slack.minCoeff() > -1e-11);
    CHECK(optimum->inequality_multipliers.minCoeff() >= 0);
    CHECK(std::abs(optimum->inequality_multipliers.dot(slack)) < 1e-10);
    CHECK((p.hessian * optimum->x + p.gradient - p.equalities.transpose() * optimum->equality_multipliers -
           p.inequalities.transpose() * optimum->inequality_multipliers)
              .norm() < 1e-10);
  }
}

TEST_CASE("contradicting constraints of a quadratic program are noticed") {
  QuadraticProgram p;
  p.hessian = MatrixX::Identity(2, 2);
  p.gradient = VectorX::Zero(2);
  p.equalities.resize(1, 2);
  p.equalities << 1, 1;
  p.equality_values = VectorX::Constant(1, 1);
  p.inequalities.resize(2, 2);
  p.inequalities << -1, 0, 0, -1;
  p.inequality_lower_bounds = VectorX::Constant(2, -0.4);  // x, y <= 0.4 while x + y = 1
  CHECK_FALSE(solve_quadratic_program(p));
}

TEST_CASE("Gauss-Newton solves to round-off at a bound too") {
  NonlinearSystem equations;
  equations.primary_rows = equations.row_count = 2;
  equations.evaluate = [](const VectorX& u, VectorX& values, MatrixX* jacobian) {
    values.resize(2);
    values << u[0] * u[1] - 0.5, u[0] * u[0] - 1;  // u = (1, 0.5) or (-1, -0.5)
    if (jacobian != nullptr) {
      jacobian->resize(2, 2);
      *jacobian << u[1], u[0], 2 * u[0], 0;
    }
    return true;
  };
  const LeastSquaresResult descent = solve_levenberg_marquardt(equations, VectorX{{0.2, 0.1}});
  CHECK(descent.max_residual < 1e-15);
  CHECK(std::abs(descent.u[1]) == doctest::Approx(0.5).epsilon(1e-15));
}

TEST_CASE("masses and inertias are polynomials, and few mechanisms suffice to find them") {
  int built = 0;
  const auto problem = design_tests::problem(
      {{"m", 0.5, 5, 2},
       {"x", -0.4, 0.4, 0.1},
       {"y", -0.2, 0.3, 0},
       {"j", 0, 1, 0.5},
       {"cw.m", 0, 3, 1},
       {"cw.x", -1, 1, 0.2}},
      [&built](const VectorX& x) {
        ++built;
        Mechanism m = design_tests::planar_arm({0.5, 0.3}, {1, x[0]});
        m.bodies[2].com = {x[1], x[2], 0};
        m.bodies[2].inertia = design_tests::about_z(x[3]);
        m.attachments = {design_tests::counterweight("cw", 1, x[5], 0.1 * x[5], x[4])};
        return m;
      },
      GoalKind::statics);
  const VariableScaling box(problem.variables);
  const VariableClassification seen = classify_variables(box, problem);
  const FeatureMap map(box, problem, seen);
  REQUIRE(map.polynomial());
  CHECK_FALSE(map.polynomial()->is_affine());
  CHECK_FALSE(seen.has_geometric());
  // 20 monomials of m, x, y; the counterweight's six and most pairs come along with them
  CHECK(built < 40);
  UniformRandom random(8);
  for (int k = 0; k < 5; ++k) {
    const VectorX u = random.sample_point(box.size());
    VectorX values, exact = map.evaluate_from_mechanism(u);
    MatrixX jacobian;
    map.evaluate(u, values, &jacobian);
    CHECK((values - exact).cwiseAbs().maxCoeff() < 1e-13 * exact.cwiseAbs().maxCoeff());
    const MatrixX differences =
        central_difference_jacobian([&](const VectorX& v) { return map.evaluate_from_mechanism(v); }, u, exact.size());
    // truncation 1e-11 and round-off 1e-16 / 1e-5
    CHECK((jacobian - differences).cwiseAbs().maxCoeff() < 1e-9);
  }
}

TEST_CASE("expressions that are no polynomials are recognised as such") {
  const auto problem = design_tests::problem(
      {{"p", 0.5, 2, 1}}, [](const VectorX& x) { return design_tests::planar_arm({0.5}, {1 / x[0]}); },
      GoalKind::statics);
  const VariableScaling box(problem.variables);
  CHECK_FALSE(FeatureMap(box, problem, classify_variables(box, problem)).polynomial());
}

TEST_CASE("a polynomial says the same in unit coordinates and in the numbers themselves") {
  SparsePolynomial p(2, 1);
  p.add({}, {{0, 1.5}});
  p.add({{0, 1}, {1, 2}}, {{0, -2}});
  p.add({{1, 1}}, {{0, 0.25}});
  const VectorX centre = VectorX{{3, -1}}, half = VectorX{{0.5, 2}};
  const SparsePolynomial q = p.substitute(centre, half);
  UniformRandom random(2);
  for (int k = 0; k < 5; ++k) {
    const VectorX u = random.sample_point(2), x = centre + half.cwiseProduct(u);
    VectorX a, b;
    p.evaluate(u, a, nullptr);
    q.evaluate(x, b, nullptr);
    CHECK(a[0] == doctest::Approx(b[0]).epsilon(1e-13));
  }
}
