#include "balance/design/exact.hpp"

#include "balance/base/extrema.hpp"
#include "balance/base/factorizations.hpp"
#include "balance/base/quadratic_program.hpp"
#include "balance/design/least_squares.hpp"
#include "balance/design/solve.hpp"

#include <algorithm>
#include <cmath>

namespace balance::design {

namespace {

/// Rows of affine conditions that are this much smaller than the largest follow from the others.
constexpr double condition_rank_tolerance = 1e-10;

/// Starts that bring no new solution before the search for more of them ends, or before a proof is tried that there is none.
constexpr int max_stall_starts = 8;
/// Solutions that are no designs, of which some are kept to say why.
constexpr std::size_t max_rejected_solutions = 3;
/// Numbers this near to a bound, their start or zero may be there.
constexpr double rounding_tolerance = 1e-8;
/// Residuals below this are as good as zero.
constexpr double residual_epsilon = 1e-15;

bool is_new_solution(const std::vector<VectorX>& known, const VectorX& u) {
  return std::none_of(known.begin(), known.end(), [&](const VectorX& k) { return max_abs(k - u) < 1e-6; });
}

}  // namespace

LinearConditions linear_conditions(const NonlinearSystem& equations, int numbers) {
  VectorX values;
  MatrixX jacobian;
  const VectorX origin = VectorX::Zero(numbers);
  equations.evaluate(origin, values, &jacobian);
  if (equations.primary_rows == 0) return {MatrixX(0, numbers), VectorX(0)};
  const MatrixX rows = jacobian.topRows(equations.primary_rows);
  const SingularValueDecomposition svd(rows, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const VectorX& s = svd.singularValues();
  Eigen::Index rank = 0;
  while (rank < s.size() && s[rank] > condition_rank_tolerance * s[0]) ++rank;
  const VectorX right = -(svd.matrixU().transpose() * values.head(equations.primary_rows));
  return {svd.matrixV().leftCols(rank).transpose(), right.head(rank).cwiseQuotient(s.head(rank))};
}

bool is_exact(const SolverContext& context, const NonlinearSystem& equations, const VectorX& u) {
  VectorX values;
  return equations.evaluate(u, values, nullptr) && max_condition_residual(equations, values) < condition_tolerance &&
         context.is_admissible(u);
}

ExactSolutions find_exact_solutions(const SolverContext& context, const NonlinearSystem& equations,
                                    const ExactSearchOptions& effort) {
  ExactSolutions search;
  UniformRandom random(context.problem.search.seed);
  int idle = 0;  // starts since the last new solution
  const std::vector<VectorX> first =
      effort.starts.empty() ? std::vector<VectorX>{context.scaling.start()} : effort.starts;
  const int known = static_cast<int>(first.size());
  for (int k = 0; k < known + effort.max_restarts && static_cast<int>(search.solutions.size()) < effort.max_solutions;
       ++k) {
    if (k > 0 && context.budget.is_spent()) break;
    if (idle++ == max_stall_starts &&
        (!search.solutions.empty() ||
         (search.rejected.empty() && effort.is_proved_infeasible && effort.is_proved_infeasible())))
      break;
    const VectorX from = k < known ? first[static_cast<std::size_t>(k)] : random.sample_point(context.scaling.size());
    ++context.budget.starts;
    LeastSquaresResult descent =
        solve_levenberg_marquardt(equations, from, 100, [&] { return context.budget.is_spent(); });
    if (descent.max_residual < condition_tolerance && is_exact(context, equations, descent.u) &&
        is_new_solution(search.solutions, descent.u)) {
      const bool usable = !effort.is_usable || effort.is_usable(descent.u);
      if (usable) {
        search.solutions.push_back(descent.u);
        ++context.budget.solutions;
        idle = 0;
      } else if (search.rejected.size() < max_rejected_solutions) {
        search.rejected.push_back(descent.u);
      }
    }
    if (k == 0 || (descent.values.size() > 0 && (search.closest.values.size() == 0 ||
                                                 descent.values.squaredNorm() < search.closest.values.squaredNorm())))
      search.closest = std::move(descent);
  }
  return search;
}

VectorX refine_solution(const NonlinearSystem& equations, const VectorX& u,
                        const std::function<VectorX(const VectorX&)>& exact) {
  VectorX best = solve_levenberg_marquardt(equations, u).u;
  if (!exact || equations.primary_rows == 0) return best;
  // The polynomials are fitted to about 1e-14 of the widest bounds: the last digits come from the mechanism itself.
  VectorX values, residual = exact(best);
  MatrixX jacobian;
  for (int k = 0; k < 2 && max_abs(residual) > 1e-16; ++k) {
    if (!equations.evaluate(best, values, &jacobian)) break;
    const auto n = best.size();
    MatrixX a(equations.primary_rows + n, n);
    a << jacobian.topRows(equations.primary_rows), 1e-9 * std::max(max_abs(jacobian), 1e-30) * MatrixX::Identity(n, n);
    VectorX b = VectorX::Zero(a.rows()), d = VectorX::Zero(n);
    b.head(equations.primary_rows) = -residual;
    bounded_least_squares(a, b, (-1.0 - best.array()).matrix(), (1.0 - best.array()).matrix(), d);
    const VectorX next = clip_to_unit_box(best + d), after = exact(next);
    if (!(after.norm() < residual.norm())) break;
    best = next;
    residual = after;
  }
  return best;
}

MatrixX tangent_space(const NonlinearSystem& equations, const VectorX& u) {
  const auto n = u.size();
  if (equations.primary_rows == 0) return MatrixX::Identity(n, n);
  VectorX values;
  MatrixX jacobian;
  if (!equations.evaluate(u, values, &jacobian)) return MatrixX(n, 0);
  ColumnPivotingQr qr(jacobian.topRows(equations.primary_rows).transpose());
  qr.setThreshold(1e-9);
  const MatrixX q = qr.householderQ() * MatrixX::Identity(n, n);
  return q.rightCols(n - qr.rank());
}

VectorX snap_to_special_values(const SolverContext& context, const NonlinearSystem& equations,
                               const std::function<double(const VectorX&)>& merit, VectorX u) {
  VectorX values;
  if (!equations.evaluate(u, values, nullptr)) return u;
  double left = max_condition_residual(equations, values), figure = merit ? merit(u) : 0;
  for (Eigen::Index i = 0; i < u.size(); ++i) {
    const double zero =
        context.scaling.half_width()[i] > 0 ? -context.scaling.centre()[i] / context.scaling.half_width()[i] : 0;
    for (const double target : {context.scaling.start()[i], -1.0, 1.0, zero}) {
      if (u[i] == target || !(std::abs(u[i] - target) < rounding_tolerance) || std::abs(target) > 1) continue;
      VectorX moved = u;
      moved[i] = target;
      if (!equations.evaluate(moved, values, nullptr) ||
          max_condition_residual(equations, values) > std::max(left, residual_epsilon))
        continue;
      const double changed = merit ? merit(moved) : 0;
      if (!(changed <= figure + 1e-12 * std::abs(figure)) || !context.is_admissible(moved)) continue;
      u = moved;
      left = max_condition_residual(equations, values);
      figure = changed;
      break;
    }
  }
  return u;
}

std::optional<VectorX> find_nearest_solution(const SolverContext& context, const LinearConditions& conditions) {
  const auto n = context.scaling.size();
  if (n == 0) return std::nullopt;
  QuadraticProgram program;
  program.hessian = MatrixX::Identity(n, n);
  program.gradient = -context.scaling.start();
  program.equalities = conditions.a;
  program.equality_values = conditions.c;
  program.inequalities.resize(2 * n, n);
  program.inequalities << MatrixX::Identity(n, n), -MatrixX::Identity(n, n);
  program.inequality_lower_bounds = VectorX::Constant(2 * n, -1);
  // concave inequalities are replaced by their tangents where they are violated
  for (int cut = 0; cut < 50; ++cut) {
    const auto optimum = solve_quadratic_program(program);
    if (!optimum) return std::nullopt;
    VectorX u = clip_to_unit_box(optimum->x), g;
    for (double& value : u)
      if (std::abs(value) > 1 - 1e-12) value = value < 0 ? -1 : 1;
    if (context.inequality_count() == 0) return u;
    MatrixX dg;
    context.evaluate_inequalities(u, g, &dg);
    if (min_coefficient(g) >= -1e-9) return u;
    for (Eigen::Index k = 0; k < g.size(); ++k) {
      if (g[k] >= -1e-9) continue;
      const auto rows = program.inequalities.rows();
      program.inequalities.conservativeResize(rows + 1, Eigen::NoChange);
      program.inequalities.row(rows) = dg.row(k);
      program.inequality_lower_bounds.conservativeResize(rows + 1);
      program.inequality_lower_bounds[rows] = dg.row(k).dot(u) - g[k];
    }
  }
  return std::nullopt;
}

}  // namespace balance::design
