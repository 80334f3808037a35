#include "balance/design/exact.hpp"

#include "balance/base/extrema.hpp"
#include "balance/base/factorizations.hpp"
#include "balance/base/quadratic_program.hpp"
#include "balance/design/least_squares.hpp"
#include "balance/design/solve.hpp"

#include <algorithm>
#include <cmath>

namespace balance::designing {

namespace {

/// Rows of affine conditions that are this much smaller than the largest follow from the others.
constexpr double dependent = 1e-10;

/// Starts that bring no new solution before the search for more of them ends, or before a proof is tried that there is none.
constexpr int idle_limit = 8;
/// Solutions that are no designs, of which some are kept to say why.
constexpr std::size_t most_unusable = 3;
/// Numbers this near to a bound, their start or zero may be there.
constexpr double nearly = 1e-8;
/// Residuals below this are as good as zero.
constexpr double negligible = 1e-15;

bool is_new(const std::vector<VectorX>& known, const VectorX& u) {
  return std::none_of(known.begin(), known.end(), [&](const VectorX& k) { return max_abs(k - u) < 1e-6; });
}

}  // namespace

LinearConditions linear_conditions(const Equations& equations, int numbers) {
  VectorX values;
  MatrixX jacobian;
  const VectorX origin = VectorX::Zero(numbers);
  equations.evaluate(origin, values, &jacobian);
  if (equations.conditions == 0) return {MatrixX(0, numbers), VectorX(0)};
  const MatrixX rows = jacobian.topRows(equations.conditions);
  const SingularValueDecomposition svd(rows, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const VectorX& s = svd.singularValues();
  Eigen::Index rank = 0;
  while (rank < s.size() && s[rank] > dependent * s[0]) ++rank;
  const VectorX right = -(svd.matrixU().transpose() * values.head(equations.conditions));
  return {svd.matrixV().leftCols(rank).transpose(), right.head(rank).cwiseQuotient(s.head(rank))};
}

bool is_exact(const Context& context, const Equations& equations, const VectorX& u) {
  VectorX values;
  return equations.evaluate(u, values, nullptr) && worst(equations, values) < met && context.allows(u);
}

ExactSearch find_exact(const Context& context, const Equations& equations, const Effort& effort) {
  ExactSearch search;
  RandomNumbers random(context.problem.search.seed);
  int idle = 0;  // starts since the last new solution
  const std::vector<VectorX> first = effort.first.empty() ? std::vector<VectorX>{context.box.start()} : effort.first;
  const int known = static_cast<int>(first.size());
  for (int k = 0; k < known + effort.restarts && static_cast<int>(search.solutions.size()) < effort.wanted; ++k) {
    if (k > 0 && context.budget.spent()) break;
    if (idle++ == idle_limit && (!search.solutions.empty() ||
                                 (search.unusable.empty() && effort.proved_impossible && effort.proved_impossible())))
      break;
    const VectorX from = k < known ? first[static_cast<std::size_t>(k)] : random.point(context.box.size());
    ++context.budget.starts;
    Descent descent = gauss_newton(equations, from, 100, [&] { return context.budget.spent(); });
    if (descent.largest < met && is_exact(context, equations, descent.u) && is_new(search.solutions, descent.u)) {
      const bool usable = !effort.usable || effort.usable(descent.u);
      if (usable) {
        search.solutions.push_back(descent.u);
        ++context.budget.solutions;
        idle = 0;
      } else if (search.unusable.size() < most_unusable) {
        search.unusable.push_back(descent.u);
      }
    }
    if (k == 0 || (descent.values.size() > 0 &&
                   (search.best.values.size() == 0 || descent.values.squaredNorm() < search.best.values.squaredNorm())))
      search.best = std::move(descent);
  }
  return search;
}

VectorX polished(const Equations& equations, const VectorX& u, const std::function<VectorX(const VectorX&)>& exact) {
  VectorX best = gauss_newton(equations, u).u;
  if (!exact || equations.conditions == 0) return best;
  // The polynomials are fitted to about 1e-14 of the widest bounds: the last digits come from the mechanism itself.
  VectorX values, residual = exact(best);
  MatrixX jacobian;
  for (int k = 0; k < 2 && max_abs(residual) > 1e-16; ++k) {
    if (!equations.evaluate(best, values, &jacobian)) break;
    const auto n = best.size();
    MatrixX a(equations.conditions + n, n);
    a << jacobian.topRows(equations.conditions), 1e-9 * std::max(max_abs(jacobian), 1e-30) * MatrixX::Identity(n, n);
    VectorX b = VectorX::Zero(a.rows()), d = VectorX::Zero(n);
    b.head(equations.conditions) = -residual;
    bounded_least_squares(a, b, (-1.0 - best.array()).matrix(), (1.0 - best.array()).matrix(), d);
    const VectorX next = clipped(best + d), after = exact(next);
    if (!(after.norm() < residual.norm())) break;
    best = next;
    residual = after;
  }
  return best;
}

MatrixX tangent_space(const Equations& equations, const VectorX& u) {
  const auto n = u.size();
  if (equations.conditions == 0) return MatrixX::Identity(n, n);
  VectorX values;
  MatrixX jacobian;
  if (!equations.evaluate(u, values, &jacobian)) return MatrixX(n, 0);
  ColumnPivotingQr qr(jacobian.topRows(equations.conditions).transpose());
  qr.setThreshold(1e-9);
  const MatrixX q = qr.householderQ() * MatrixX::Identity(n, n);
  return q.rightCols(n - qr.rank());
}

VectorX tidied(const Context& context, const Equations& equations, const std::function<double(const VectorX&)>& merit,
               VectorX u) {
  VectorX values;
  if (!equations.evaluate(u, values, nullptr)) return u;
  double left = worst(equations, values), figure = merit ? merit(u) : 0;
  for (Eigen::Index i = 0; i < u.size(); ++i) {
    const double zero = context.box.half()[i] > 0 ? -context.box.centre()[i] / context.box.half()[i] : 0;
    for (const double target : {context.box.start()[i], -1.0, 1.0, zero}) {
      if (u[i] == target || !(std::abs(u[i] - target) < nearly) || std::abs(target) > 1) continue;
      VectorX moved = u;
      moved[i] = target;
      if (!equations.evaluate(moved, values, nullptr) || worst(equations, values) > std::max(left, negligible))
        continue;
      const double changed = merit ? merit(moved) : 0;
      if (!(changed <= figure + 1e-12 * std::abs(figure)) || !context.allows(moved)) continue;
      u = moved;
      left = worst(equations, values);
      figure = changed;
      break;
    }
  }
  return u;
}

std::optional<VectorX> nearest_exact(const Context& context, const LinearConditions& conditions) {
  const auto n = context.box.size();
  if (n == 0) return std::nullopt;
  QuadraticProgram program;
  program.hessian = MatrixX::Identity(n, n);
  program.gradient = -context.box.start();
  program.equalities = conditions.a;
  program.equal_to = conditions.c;
  program.inequalities.resize(2 * n, n);
  program.inequalities << MatrixX::Identity(n, n), -MatrixX::Identity(n, n);
  program.at_least = VectorX::Constant(2 * n, -1);
  // concave inequalities are replaced by their tangents where they are violated
  for (int cut = 0; cut < 50; ++cut) {
    const auto optimum = solve(program);
    if (!optimum) return std::nullopt;
    VectorX u = clipped(optimum->x), g;
    for (double& value : u)
      if (std::abs(value) > 1 - 1e-12) value = value < 0 ? -1 : 1;
    if (context.inequalities() == 0) return u;
    MatrixX dg;
    context.evaluate_inequalities(u, g, &dg);
    if (min_coefficient(g) >= -1e-9) return u;
    for (Eigen::Index k = 0; k < g.size(); ++k) {
      if (g[k] >= -1e-9) continue;
      const auto rows = program.inequalities.rows();
      program.inequalities.conservativeResize(rows + 1, Eigen::NoChange);
      program.inequalities.row(rows) = dg.row(k);
      program.at_least.conservativeResize(rows + 1);
      program.at_least[rows] = dg.row(k).dot(u) - g[k];
    }
  }
  return std::nullopt;
}

}  // namespace balance::designing
