#include "balance/design/optimum.hpp"

#include "balance/base/factorizations.hpp"
#include "balance/design/nlopt_search.hpp"
#include "balance/design/solve.hpp"

#include <algorithm>
#include <cmath>

namespace balance::designing {

namespace {

std::string local_method(const Context& context, const FigureOfMerit& merit) {
  const std::string& asked = context.problem.search.local;
  return asked != "auto" ? asked : merit.simulated() ? "cobyla" : "slsqp";
}

SearchLimits local_limits(const Context& context, const FigureOfMerit& merit, const Deadline& deadline) {
  SearchLimits limits;
  limits.evaluations = std::min(context.problem.search.evaluations, 2000);
  limits.step = 0.1;
  if (merit.simulated()) {
    limits.seconds = deadline.left();
    limits.relative = 1e-6;
  }
  return limits;
}

/// Worse than anything worth finding, yet a number that searches can compare.
double penalty(double reference) { return 1e3 * (std::abs(reference) + 1); }

void add_physical(const Context& context, Program& program) {
  program.inequality_count = context.physical.size();
  program.inequalities = [&context](const VectorX& u, VectorX& values, MatrixX* jacobian) {
    VectorX features;
    MatrixX slopes;
    context.map.evaluate(u, features, jacobian != nullptr ? &slopes : nullptr);
    context.physical.evaluate(features, &slopes, values, jacobian);
  };
}

/// Conditions that are independent at u; the others follow from them near it.
std::vector<int> independent_rows(const Equations& equations, const VectorX& u) {
  VectorX values;
  MatrixX jacobian;
  std::vector<int> rows;
  if (equations.conditions == 0 || !equations.evaluate(u, values, &jacobian)) return rows;
  Eigen::ColPivHouseholderQR<MatrixX> qr(jacobian.topRows(equations.conditions).transpose());
  qr.setThreshold(1e-9);
  for (Eigen::Index k = 0; k < qr.rank(); ++k) rows.push_back(qr.colsPermutation().indices()[k]);
  std::sort(rows.begin(), rows.end());
  return rows;
}

/// Methods with gradients treat the conditions as equalities.
VectorX with_equalities(const Context& context, const FigureOfMerit& merit, const Equations& equations,
                        const VectorX& start, const std::string& method, const SearchLimits& limits) {
  Program program;
  program.size = context.box.size();
  VectorX slope;
  const double value = std::abs(merit(start, &slope)), steepest = slope.cwiseAbs().maxCoeff();
  // of the order of one, as the conditions are: else its unit decides where a search ends
  const double size = std::isfinite(value + steepest) && value + steepest > 0 ? std::max(value, steepest) : 1;
  program.objective = [&merit, size](const VectorX& u, VectorX* gradient) {
    const double here = merit(u, gradient) / size;
    if (gradient != nullptr) *gradient /= size;
    return here;
  };
  const std::vector<int> rows = independent_rows(equations, start);
  program.equality_count = static_cast<int>(rows.size());
  program.equalities = [&](const VectorX& u, VectorX& values, MatrixX* jacobian) {
    VectorX all;
    MatrixX slopes;
    if (!equations.evaluate(u, all, jacobian != nullptr ? &slopes : nullptr)) {
      all.setConstant(equations.rows, 1);  // far from met
      slopes.setZero(equations.rows, u.size());
    }
    values = all(rows);
    if (jacobian != nullptr) *jacobian = slopes(rows, Eigen::all);
  };
  add_physical(context, program);
  return search_locally(method, program, start, limits).u;
}

/// Methods without gradients move in the tangent space of the conditions; every point is brought back onto them.
VectorX in_tangent_space(const Context& context, const FigureOfMerit& merit, const Equations& equations,
                         const std::function<VectorX(const VectorX&)>& back, const VectorX& start,
                         const std::string& method, const SearchLimits& limits) {
  const MatrixX tangents = tangent_space(equations, start);
  if (tangents.cols() == 0) return start;
  const double worst_value = penalty(merit(start, nullptr));
  Program program;
  program.size = static_cast<int>(tangents.cols());
  program.bound = 2 * std::sqrt(static_cast<double>(start.size()));
  const auto point = [&](const VectorX& z) { return back(clipped(start + tangents * z)); };
  program.objective = [&](const VectorX& z, VectorX* gradient) {
    if (gradient != nullptr) throw std::logic_error("a method without gradients asked for one");
    const VectorX u = point(z);
    if (!is_exact(context, equations, u)) return worst_value;
    const double value = merit(u, nullptr);
    return std::isfinite(value) ? value : worst_value;
  };
  return point(search_locally(method, program, VectorX::Zero(tangents.cols()), limits).u);
}

}  // namespace

Optimum best_exact(const Context& context, const FigureOfMerit& merit, const Equations& equations,
                   const std::function<VectorX(const VectorX&)>& back, const std::vector<VectorX>& solutions,
                   const Deadline& deadline) {
  const std::string method = local_method(context, merit);
  Optimum best;
  const auto consider = [&](const VectorX& u) {
    if (!is_exact(context, equations, u)) return;
    const double value = merit(u, nullptr);
    if (best.u.size() == 0 || !(best.value <= value)) {
      if (best.u.size() > 0 && !std::isfinite(value)) return;
      best.u = u;
      best.value = value;
    }
  };
  for (const VectorX& solution : solutions) {
    consider(solution);
    if (tangent_space(equations, solution).cols() == 0) continue;
    const SearchLimits limits = local_limits(context, merit, deadline);
    if (wants_gradients(method)) {
      consider(back(with_equalities(context, merit, equations, solution, method, limits)));
      continue;
    }
    VectorX from = solution;
    for (SearchLimits round = limits; round.step > 1e-4; round.step /= 4) {
      const double before = merit(from, nullptr);
      const VectorX found = in_tangent_space(context, merit, equations, back, from, method, round);
      consider(found);
      if (!(merit(found, nullptr) < before) || !is_exact(context, equations, found)) break;
      from = found;
      if (merit.simulated()) round.seconds = deadline.left();
    }
  }
  if (best.u.size() == 0) best.u = solutions.front();
  return best;
}

Optimum best_compromise(const Context& context, const FigureOfMerit& merit, const VectorX& start,
                        const Deadline& deadline) {
  const SearchOptions& options = context.problem.search;
  const double reference = merit(start, nullptr);
  Program program;
  program.size = context.box.size();
  program.objective = [&](const VectorX& u, VectorX* gradient) {
    const double value = merit(u, gradient);
    VectorX features;
    context.map.evaluate(u, features, nullptr);
    return context.physical.holds(features) && std::isfinite(value) ? value : penalty(reference);
  };
  SearchLimits limits{options.evaluations, 0, 0};
  if (merit.simulated()) limits.seconds = deadline.left() / 2;
  const VectorX coarse = search_globally(options.global, program, start, limits, options.seed, !merit.simulated()).u;
  Optimum best{start, reference, {}, false};
  const auto consider = [&](const VectorX& u) {
    const double value = merit(u, nullptr);
    if (context.is_physical(u) && std::isfinite(value) && !(best.value <= value)) best.u = u, best.value = value;
  };
  consider(coarse);
  program.objective = [&](const VectorX& u, VectorX* gradient) {
    const double value = merit(u, gradient);
    return std::isfinite(value) ? value : penalty(reference);
  };
  add_physical(context, program);
  for (const VectorX& from : {coarse, start}) {
    consider(search_locally(local_method(context, merit), program, from, local_limits(context, merit, deadline)).u);
  }
  best.bound = std::numeric_limits<double>::quiet_NaN();
  return best;
}

VectorX least_residual(const Context& context, const Equations& equations, const Descent& start, int evaluations) {
  const auto conditions = equations.conditions;
  const auto sum_of_squares = [&](const VectorX& u, VectorX* gradient, int rows) {
    VectorX values;
    MatrixX jacobian;
    if (!equations.evaluate(u, values, gradient != nullptr ? &jacobian : nullptr)) {
      if (gradient != nullptr) gradient->setZero(u.size());
      return penalty(1);
    }
    if (gradient != nullptr) *gradient = 2 * jacobian.topRows(rows).transpose() * values.head(rows);
    return values.head(rows).squaredNorm();
  };
  Program program;
  program.size = context.box.size();
  program.objective = [&](const VectorX& u, VectorX* gradient) { return sum_of_squares(u, gradient, equations.rows); };
  const SearchOptions& options = context.problem.search;
  Descent best = start;
  if (evaluations > 0) {
    const VectorX coarse = search_globally(options.global, program, start.u, {evaluations, 0, 0}, options.seed, true).u;
    Descent found = gauss_newton(equations, coarse);
    if (found.values.size() > 0 && (best.values.size() == 0 || found.values.squaredNorm() < best.values.squaredNorm()))
      best = std::move(found);
  }
  if (context.is_physical(best.u)) return best.u;
  // the inequalities were one residual among others: now they are kept
  program.objective = [&](const VectorX& u, VectorX* gradient) { return sum_of_squares(u, gradient, conditions); };
  add_physical(context, program);
  const VectorX kept = search_locally("slsqp", program, context.box.start(), {2000, 0, 1e-12}).u;
  if (context.is_physical(kept)) return kept;
  double part = 1;
  while (part > 1e-9 && !context.is_physical(context.box.start() + part * (kept - context.box.start()))) part *= 0.9;
  return part > 1e-9 ? VectorX(context.box.start() + part * (kept - context.box.start())) : context.box.start();
}

}  // namespace balance::designing
