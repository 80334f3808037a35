#include "balance/design/freedom.hpp"

#include "balance/base/factorizations.hpp"
#include "balance/conditions/linear_program.hpp"

#include <algorithm>
#include <cmath>

namespace balance::designing {

namespace {

/// Numbers this near to a bound lie on it; physical limits likewise.
constexpr double touching = 1e-9;
/// Directions that move a number less than this part of the whole do not move it.
constexpr double still = 1e-6;

/// Orthonormal columns that span what the rows leave free within the span of `basis`.
MatrixX null_within(const MatrixX& basis, const MatrixX& rows, double tolerance) {
  if (basis.cols() == 0 || rows.rows() == 0) return basis;
  const MatrixX inside = rows * basis;
  const double size = rows.norm();
  if (!(size > 0)) return basis;
  const SingularValueDecomposition svd(inside, Eigen::ComputeFullV);
  Eigen::Index rank = 0;
  while (rank < svd.singularValues().size() && svd.singularValues()[rank] > tolerance * size) ++rank;
  return basis * svd.matrixV().rightCols(basis.cols() - rank);
}

/// Rows that a direction must not make negative: bounds and physical limits that u lies on.
MatrixX touched_limits(const Context& context, const VectorX& u) {
  const auto n = u.size();
  std::vector<VectorX> rows;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (u[i] <= -1 + touching) rows.push_back(VectorX::Unit(n, i));
    if (u[i] >= 1 - touching) rows.push_back(-VectorX::Unit(n, i));
  }
  if (context.inequalities() > 0) {
    VectorX g;
    MatrixX dg;
    context.evaluate_inequalities(u, g, &dg);
    for (Eigen::Index k = 0; k < g.size(); ++k)
      if (g[k] < touching && dg.row(k).allFinite()) rows.push_back(dg.row(k).transpose());
  }
  MatrixX limits(static_cast<Eigen::Index>(rows.size()), n);
  for (std::size_t k = 0; k < rows.size(); ++k) limits.row(static_cast<Eigen::Index>(k)) = rows[k].transpose();
  return limits;
}

/// What the cone of directions within the span that keep all limits spans itself: limits that none of them leaves are equalities.
MatrixX allowed(const MatrixX& basis, const MatrixX& limits) {
  const auto k = basis.cols(), m = limits.rows();
  if (k == 0 || m == 0) return basis;
  // as many limits as possible are left by 1: what stays at 0 can be left by no direction
  LinearProgram program(k + m);
  program.lower.tail(m).setZero();
  program.upper.tail(m).setOnes();
  program.cost.tail(m).setConstant(-1);
  const MatrixX inside = limits * basis;
  for (Eigen::Index row = 0; row < m; ++row) {
    VectorX coefficients = VectorX::Zero(k + m);
    const double size = inside.row(row).norm();
    if (size > still * limits.row(row).norm()) coefficients.head(k) = inside.row(row).transpose() / size;
    coefficients[k + row] = -1;
    program.add_row(0, coefficients, unbounded);
  }
  const ProgramSolution solution = minimize(program);
  if (solution.status != ProgramStatus::solved) return basis;
  std::vector<Eigen::Index> kept;
  for (Eigen::Index row = 0; row < m; ++row)
    if (solution.x[k + row] < 0.5) kept.push_back(row);
  return null_within(basis, limits(kept, Eigen::all), still);
}

/// Directions in which the objective neither changes nor curves.
MatrixX level(const FigureOfMerit& merit, const MatrixX& basis, const VectorX& u) {
  VectorX slope;
  const double value = merit(u, &slope);
  if (!std::isfinite(value) || !slope.allFinite() || basis.cols() == 0) return basis;
  const double size = std::max(std::abs(value), slope.norm());
  MatrixX flat = basis;
  if ((basis.transpose() * slope).norm() > still * size) flat = null_within(basis, slope.transpose(), still);
  if (flat.cols() == 0) return flat;
  constexpr double step = 1e-3;
  MatrixX curvature(flat.cols(), flat.cols());
  for (Eigen::Index k = 0; k < flat.cols(); ++k) {
    VectorX ahead, behind;
    merit(u + step * flat.col(k), &ahead);
    merit(u - step * flat.col(k), &behind);
    curvature.col(k) = flat.transpose() * (ahead - behind) / (2 * step);
  }
  if (!curvature.allFinite()) return flat;
  const SymmetricEigenSolver solver((curvature + curvature.transpose()) / 2);
  std::vector<Eigen::Index> straight;
  for (Eigen::Index k = 0; k < flat.cols(); ++k)
    if (std::abs(solver.eigenvalues()[k]) <= still * size) straight.push_back(k);
  return flat * solver.eigenvectors()(Eigen::all, straight);
}

std::vector<int> moving(const MatrixX& basis) {
  std::vector<int> numbers;
  for (Eigen::Index i = 0; i < basis.rows(); ++i)
    if (basis.cols() > 0 && basis.row(i).norm() > still) numbers.push_back(static_cast<int>(i));
  return numbers;
}

}  // namespace

Freedom find_freedom(const Context& context, const Equations& equations, const FigureOfMerit* merit, const VectorX& u,
                     bool precise) {
  Freedom freedom;
  const auto n = u.size();
  VectorX values;
  MatrixX jacobian(0, n);
  if (equations.conditions > 0 && !equations.evaluate(u, values, &jacobian)) return freedom;
  const MatrixX rows = jacobian.topRows(equations.conditions);
  const MatrixX limits = touched_limits(context, u);
  const MatrixX free = null_within(MatrixX::Identity(n, n), rows, precise ? 1e-9 : still);
  MatrixX directions = allowed(free, limits);
  freedom.of_conditions = static_cast<int>(directions.cols());
  freedom.numbers = moving(directions);
  if (merit == nullptr) {
    freedom.left = freedom.of_conditions;
    return freedom;
  }
  if (merit->simulated() || !precise) return freedom;  // what the figure does along them is not known
  directions = allowed(level(*merit, free, u), limits);
  freedom.left = static_cast<int>(directions.cols());
  freedom.numbers = moving(directions);
  return freedom;
}

}  // namespace balance::designing
