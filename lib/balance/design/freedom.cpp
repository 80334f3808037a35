#include "balance/design/freedom.hpp"

#include "balance/base/factorizations.hpp"
#include "balance/conditions/linear_program.hpp"

#include <algorithm>
#include <cmath>

namespace balance::design {

namespace {

/// Numbers this near to a bound lie on it; physical limits likewise.
constexpr double active_bound_tolerance = 1e-9;
/// Directions that move a number less than this part of the whole do not move it.
constexpr double null_space_tolerance = 1e-6;

/// Orthonormal columns that span what the rows leave free within the span of `basis`.
MatrixX restrict_to_null_space(const MatrixX& basis, const MatrixX& rows, double tolerance) {
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
MatrixX active_constraint_normals(const SolverContext& context, const VectorX& u) {
  const auto n = u.size();
  std::vector<VectorX> rows;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (u[i] <= -1 + active_bound_tolerance) rows.push_back(VectorX::Unit(n, i));
    if (u[i] >= 1 - active_bound_tolerance) rows.push_back(-VectorX::Unit(n, i));
  }
  if (context.inequality_count() > 0) {
    VectorX g;
    MatrixX dg;
    context.evaluate_inequalities(u, g, &dg);
    for (Eigen::Index k = 0; k < g.size(); ++k)
      if (g[k] < active_bound_tolerance && dg.row(k).allFinite()) rows.push_back(dg.row(k).transpose());
  }
  MatrixX limits(static_cast<Eigen::Index>(rows.size()), n);
  for (std::size_t k = 0; k < rows.size(); ++k) limits.row(static_cast<Eigen::Index>(k)) = rows[k].transpose();
  return limits;
}

/// What the cone of directions within the span that keep all limits spans itself: limits that none of them leaves are equalities.
MatrixX span_feasible_directions(const MatrixX& basis, const MatrixX& limits) {
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
    if (size > null_space_tolerance * limits.row(row).norm()) coefficients.head(k) = inside.row(row).transpose() / size;
    coefficients[k + row] = -1;
    program.add_row(0, coefficients, no_bound);
  }
  const LinearProgramSolution solution = solve_linear_program(program);
  if (solution.status != LinearProgramStatus::optimal) return basis;
  std::vector<Eigen::Index> kept;
  for (Eigen::Index row = 0; row < m; ++row)
    if (solution.x[k + row] < 0.5) kept.push_back(row);
  return restrict_to_null_space(basis, limits(kept, Eigen::all), null_space_tolerance);
}

/// Directions in which the objective neither changes nor curves.
MatrixX find_flat_directions(const ScaledObjective& merit, const MatrixX& basis, const VectorX& u) {
  VectorX slope;
  const double value = merit(u, &slope);
  if (!std::isfinite(value) || !slope.allFinite() || basis.cols() == 0) return basis;
  const double size = std::max(std::abs(value), slope.norm());
  MatrixX flat = basis;
  if ((basis.transpose() * slope).norm() > null_space_tolerance * size)
    flat = restrict_to_null_space(basis, slope.transpose(), null_space_tolerance);
  if (flat.cols() == 0) return flat;
  constexpr double curvature_difference_step = 1e-3;
  MatrixX curvature(flat.cols(), flat.cols());
  for (Eigen::Index k = 0; k < flat.cols(); ++k) {
    VectorX ahead, behind;
    merit(u + curvature_difference_step * flat.col(k), &ahead);
    merit(u - curvature_difference_step * flat.col(k), &behind);
    curvature.col(k) = flat.transpose() * (ahead - behind) / (2 * curvature_difference_step);
  }
  if (!curvature.allFinite()) return flat;
  const SymmetricEigenSolver solver((curvature + curvature.transpose()) / 2);
  std::vector<Eigen::Index> straight;
  for (Eigen::Index k = 0; k < flat.cols(); ++k)
    if (std::abs(solver.eigenvalues()[k]) <= null_space_tolerance * size) straight.push_back(k);
  return flat * solver.eigenvectors()(Eigen::all, straight);
}

std::vector<int> list_moving_variables(const MatrixX& basis) {
  std::vector<int> numbers;
  for (Eigen::Index i = 0; i < basis.rows(); ++i)
    if (basis.cols() > 0 && basis.row(i).norm() > null_space_tolerance) numbers.push_back(static_cast<int>(i));
  return numbers;
}

}  // namespace

SolutionSet analyse_solution_set(const SolverContext& context, const NonlinearSystem& equations,
                                 const ScaledObjective* merit, const VectorX& u, bool precise) {
  SolutionSet freedom;
  const auto n = u.size();
  VectorX values;
  MatrixX jacobian(0, n);
  if (equations.primary_rows > 0 && !equations.evaluate(u, values, &jacobian)) return freedom;
  const MatrixX rows = jacobian.topRows(equations.primary_rows);
  const MatrixX limits = active_constraint_normals(context, u);
  const MatrixX free = restrict_to_null_space(MatrixX::Identity(n, n), rows, precise ? 1e-9 : null_space_tolerance);
  MatrixX directions = span_feasible_directions(free, limits);
  freedom.dimension = static_cast<int>(directions.cols());
  freedom.free_variables = list_moving_variables(directions);
  if (merit == nullptr) {
    freedom.optimal_dimension = freedom.dimension;
    return freedom;
  }
  if (merit->is_simulated() || !precise) return freedom;  // what the figure does along them is not known
  directions = span_feasible_directions(find_flat_directions(*merit, free, u), limits);
  freedom.optimal_dimension = static_cast<int>(directions.cols());
  freedom.free_variables = list_moving_variables(directions);
  return freedom;
}

}  // namespace balance::design
