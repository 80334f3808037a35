#include "balance/synthesis/design/feasible_directions.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/linear_program.hpp"
#include "balance/synthesis/design/problem_functions.hpp"

#include <vector>

namespace balance::design {

namespace {

/// Variables this close to a bound count as lying on it; the same holds for physical limits.
constexpr double active_bound_tolerance = 1e-9;

}  // namespace

MatrixX restrict_to_null_space(const MatrixX& basis, const MatrixX& rows, double tolerance) {
  if (basis.cols() == 0 || rows.rows() == 0) return basis;
  const MatrixX projected = rows * basis;
  const double size = rows.norm();
  if (!(size > 0)) return basis;
  const numerics::SingularValueDecomposition svd(projected, Eigen::ComputeFullV);
  Eigen::Index rank = 0;
  while (rank < svd.singularValues().size() && svd.singularValues()[rank] > tolerance * size) ++rank;
  return basis * svd.matrixV().rightCols(basis.cols() - rank);
}

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

MatrixX span_feasible_directions(const MatrixX& basis, const MatrixX& limits) {
  const auto k = basis.cols(), m = limits.rows();
  if (k == 0 || m == 0) return basis;
  // Maximises the number of limits that are left by 1; a slack that stays 0 means that no direction leaves the limit.
  numerics::LinearProgram program(k + m);
  program.lower.tail(m).setZero();
  program.upper.tail(m).setOnes();
  program.cost.tail(m).setConstant(-1);
  const MatrixX projected = limits * basis;
  for (Eigen::Index row = 0; row < m; ++row) {
    VectorX coefficients = VectorX::Zero(k + m);
    const double size = projected.row(row).norm();
    if (size > null_space_tolerance * limits.row(row).norm())
      coefficients.head(k) = projected.row(row).transpose() / size;
    coefficients[k + row] = -1;
    program.add_row(0, coefficients, numerics::no_bound);
  }
  const numerics::LinearProgramSolution solution = solve_linear_program(program);
  if (solution.status != numerics::LinearProgramStatus::optimal) return basis;
  std::vector<Eigen::Index> equality_rows;
  for (Eigen::Index row = 0; row < m; ++row)
    if (solution.x[k + row] < 0.5) equality_rows.push_back(row);
  return restrict_to_null_space(basis, limits(equality_rows, Eigen::all), null_space_tolerance);
}

}  // namespace balance::design
