#include "balance/design/optimum.hpp"

#include "balance/base/extrema.hpp"
#include "balance/base/factorizations.hpp"
#include "balance/design/limits.hpp"
#include "balance/design/maxima_search.hpp"
#include "balance/design/nlopt_search.hpp"
#include "balance/design/seek.hpp"
#include "balance/design/solve.hpp"
#include "balance/design/two_levels.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace balance::design {

namespace {

std::string choose_local_method(const SolverContext& context, const ScaledObjective& merit) {
  const std::string& asked = context.problem.search.local;
  return asked != "auto" ? asked : merit.is_simulated() ? "cobyla" : "slsqp";
}

StoppingCriteria make_stopping_criteria(const SolverContext& context, const ScaledObjective& merit) {
  StoppingCriteria limits;
  limits.max_evaluations = std::min(context.problem.search.max_evaluations, 2000);
  limits.max_time = context.budget.remaining_time();
  limits.stop = context.budget.make_stop_callback();
  limits.initial_step = 0.1;
  if (merit.is_simulated()) limits.relative_tolerance = 1e-6;
  return limits;
}

/// Worse than anything worth finding, yet a number that searches can compare.
double undefined_penalty(double reference) { return 1e3 * (std::abs(reference) + 1); }

void add_design_inequalities(const SolverContext& context, NonlinearProgram& program) {
  program.inequality_count = context.inequality_count();
  program.inequalities = [&context](const VectorX& u, VectorX& values, MatrixX* jacobian) {
    context.evaluate_inequalities(u, values, jacobian);
  };
}

/// Conditions that are independent at u; the others follow from them near it.
std::vector<int> independent_rows(const NonlinearSystem& equations, const VectorX& u) {
  VectorX values;
  MatrixX jacobian;
  std::vector<int> rows;
  if (equations.primary_rows == 0 || !equations.evaluate(u, values, &jacobian)) return rows;
  ColumnPivotingQr qr(jacobian.topRows(equations.primary_rows).transpose());
  qr.setThreshold(1e-9);
  for (Eigen::Index k = 0; k < qr.rank(); ++k) rows.push_back(qr.colsPermutation().indices()[k]);
  std::sort(rows.begin(), rows.end());
  return rows;
}

/// Methods with gradients treat the conditions as equalities.
VectorX optimise_with_equalities(const SolverContext& context, const ScaledObjective& merit,
                                 const NonlinearSystem& equations, const VectorX& start, const std::string& method,
                                 const StoppingCriteria& limits) {
  NonlinearProgram program;
  program.size = context.scaling.size();
  VectorX slope;
  const double value = std::abs(merit(start, &slope)), steepest = max_abs(slope);
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
      all.setConstant(equations.row_count, 1);  // far from met
      slopes.setZero(equations.row_count, u.size());
    }
    values = all(rows);
    if (jacobian != nullptr) *jacobian = slopes(rows, Eigen::all);
  };
  add_design_inequalities(context, program);
  return search_locally(method, program, start, limits).u;
}

/// Points of the box from which a search of a figure that takes a simulation goes down, besides what is known.
int count_start_points(const ScaledObjective& merit, Eigen::Index size) {
  return merit.is_simulated() ? std::min(6 + 6 * static_cast<int>(size), 40) : 0;
}

/// Moves in the tangent space of the conditions; every point is brought back onto them.
class TangentSpaceSearch {
 public:
  TangentSpaceSearch(const SolverContext& context, const ScaledObjective& merit, const NonlinearSystem& equations,
                     const std::function<VectorX(const VectorX&)>& back)
      : context_(context), objective_(merit), equations_(equations), back_(back) {}

  /// @param others exact too
  /// @param descents 0: polishes only
  VectorX from(const VectorX& start, const std::vector<VectorX>& others, int descents, double step) const {
    const MatrixX tangents = tangent_space(equations_, start);
    if (tangents.cols() == 0) return start;
    const auto point = [&](const VectorX& z) { return back_(clip_to_unit_box(start + tangents * z)); };
    MultistartSettings task;
    task.objective = [&](const VectorX& z) {
      const VectorX u = point(z);
      return is_exact(context_, equations_, u) ? objective_(u, nullptr) : std::numeric_limits<double>::quiet_NaN();
    };
    task.bound = 2 * std::sqrt(static_cast<double>(start.size()));
    task.starts = {VectorX::Zero(tangents.cols())};
    for (const VectorX& other : others) task.starts.push_back(tangents.transpose() * (other - start));
    const std::string& asked = context_.problem.search.local;
    task.method = asked == "auto" || is_gradient_based(asked) ? "cobyla" : asked;
    task.max_local_searches = descents;
    task.max_evaluations = std::min(context_.problem.search.max_evaluations, objective_.is_simulated() ? 400 : 2000);
    task.initial_step = step;
    task.min_step = objective_.is_simulated() ? 1e-5 : 1e-4;
    return point(search_multistart(task, context_.budget).u);
  }

 private:
  const SolverContext& context_;
  const ScaledObjective& objective_;
  const NonlinearSystem& equations_;
  const std::function<VectorX(const VectorX&)>& back_;
};

/// Keeps the best admissible point.
class BestPoint {
 public:
  explicit BestPoint(const ScaledObjective& merit) : objective_(merit) {}
  bool consider(const VectorX& u) {
    const double value = objective_(u, nullptr);
    if (!std::isfinite(value) || optimum.value <= value) return false;
    optimum.u = u;
    optimum.value = value;
    return true;
  }
  Optimum optimum{{}, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN(), false};

 private:
  const ScaledObjective& objective_;
};

/// Where numbers of the motion alone are free besides masses, the figure's slopes by them are known. @return they led somewhere
bool try_bilevel_search(const SolverContext& context, const ScaledObjective& merit, const NonlinearSystem& equations,
                        const std::function<VectorX(const VectorX&)>& back, BestPoint& best) {
  if (!merit.is_simulated() || context.problem.is_subproblem || context.classification.has_geometric()) return false;
  bool any = false;
  for (const VectorX& end : search_bilevel(context, best.optimum.u, &merit, false).balanced)
    if (const VectorX u = back(end); is_exact(context, equations, u)) any = best.consider(u) || any;
  return any;
}

}  // namespace

Optimum optimise_exact_solutions(const SolverContext& context, const ScaledObjective& merit,
                                 const NonlinearSystem& equations, const std::function<VectorX(const VectorX&)>& back,
                                 const std::vector<VectorX>& solutions) {
  const std::string method = choose_local_method(context, merit);
  BestPoint best(merit);
  for (const VectorX& solution : solutions)
    if (is_exact(context, equations, solution)) best.consider(solution);
  if (best.optimum.u.size() == 0) {
    best.optimum.u = solutions.front();
    return best.optimum;
  }
  if (is_gradient_based(method)) {
    for (const VectorX& solution : solutions) {
      if (context.budget.is_spent() || tangent_space(equations, solution).cols() == 0) continue;
      ++context.budget.local_searches;
      const VectorX u = back(optimise_with_equalities(context, merit, equations, solution, method,
                                                      make_stopping_criteria(context, merit)));
      if (is_exact(context, equations, u)) best.consider(u);
    }
  }
  const auto freedoms = tangent_space(equations, best.optimum.u).cols();
  if (freedoms == 0) return best.optimum;
  const bool slopes = try_bilevel_search(context, merit, equations, back, best);
  std::vector<VectorX> others = solutions;
  for (const VectorX& u : low_discrepancy_points(slopes ? 0 : count_start_points(merit, freedoms),
                                                 context.scaling.size(), context.problem.search.seed))
    others.push_back(u);
  const TangentSpaceSearch search(context, merit, equations, back);
  const bool only_polish = is_gradient_based(method) && !merit.is_simulated();
  if (only_polish && (freedoms > 8 || context.problem.is_subproblem)) return best.optimum;
  // the tangents of a curved set of solutions turn
  int descents = only_polish ? 0 : slopes ? 1 : 3;
  for (double step = 0.1; step > 1e-3 && !context.budget.is_spent(); step /= 4, descents = std::min(descents, 1)) {
    const VectorX u = search.from(best.optimum.u, descents > 1 ? others : std::vector<VectorX>{}, descents, step);
    if (!is_exact(context, equations, u) || !best.consider(u)) break;
  }
  return best.optimum;
}

namespace {

/// Methods with gradients keep the physical limits as constraints.
VectorX optimise_with_inequalities(const SolverContext& context, const ScaledObjective& merit, const VectorX& from) {
  NonlinearProgram program;
  program.size = context.scaling.size();
  program.objective = [&](const VectorX& u, VectorX* gradient) { return merit(u, gradient); };
  add_design_inequalities(context, program);
  ++context.budget.local_searches;
  return search_locally(choose_local_method(context, merit), program, from, make_stopping_criteria(context, merit)).u;
}

}  // namespace

Optimum optimise_compromise(const SolverContext& context, const ScaledObjective& merit, const VectorX& start) {
  const SearchOptions& options = context.problem.search;
  BestPoint best(merit);
  const auto consider = [&](const VectorX& u) {
    if (context.is_admissible(u)) best.consider(u);
  };
  consider(start);
  if (merit.has_max_terms() && options.local == "auto" && context.limits->size() == 0) {
    for (const VectorX& u : minimise_max_terms(context, merit, start)) consider(u);
    if (best.optimum.u.size() > 0) return best.optimum;
  }
  const auto value = [&](const VectorX& u) {
    VectorX features;
    context.features.evaluate(u, features, nullptr);
    const bool allowed = context.physical_constraints.is_satisfied(features) && context.limits->is_satisfied(u);
    return allowed ? merit(u, nullptr) : std::numeric_limits<double>::quiet_NaN();
  };
  NonlinearProgram program;
  program.size = context.scaling.size();
  program.objective = [&](const VectorX& u, VectorX* gradient) {
    const double inside = value(u);
    if (gradient != nullptr) merit(u, gradient);
    ++context.budget.evaluations;
    return inside;
  };
  const int evaluations = merit.is_simulated() ? std::max(1, options.max_evaluations / 20) : options.max_evaluations;
  const StoppingCriteria limits{evaluations, context.budget.remaining_time() / 2, 0, 0,
                                context.budget.make_stop_callback()};
  const VectorX coarse =
      context.scaling.size() > 0
          ? search_globally(options.global, program, start, limits, options.seed, !merit.is_simulated()).u
          : start;
  consider(coarse);
  if (is_gradient_based(choose_local_method(context, merit)))
    for (const VectorX& from : {coarse, start})
      if (std::isfinite(merit(from, nullptr))) consider(optimise_with_inequalities(context, merit, from));
  MultistartSettings task;
  task.objective = value;
  task.starts = {best.optimum.u.size() > 0 ? best.optimum.u : start, coarse, start};
  for (const VectorX& u :
       low_discrepancy_points(count_start_points(merit, start.size()), context.scaling.size(), options.seed))
    task.starts.push_back(u);
  task.method = is_gradient_based(choose_local_method(context, merit)) ? "cobyla" : choose_local_method(context, merit);
  task.max_evaluations = std::min(options.max_evaluations, merit.is_simulated() ? 400 : 2000);
  task.min_step = merit.is_simulated() ? 1e-6 : 1e-7;
  const MultistartResult found = search_multistart(task, context.budget);
  consider(found.u);
  if (best.optimum.u.size() == 0) best.optimum.u = start;
  return best.optimum;
}

VectorX minimise_residual(const SolverContext& context, const NonlinearSystem& equations,
                          const LeastSquaresResult& start, int evaluations) {
  const auto conditions = equations.primary_rows;
  const auto sum_of_squares = [&](const VectorX& u, VectorX* gradient, int rows) {
    VectorX values;
    MatrixX jacobian;
    if (!equations.evaluate(u, values, gradient != nullptr ? &jacobian : nullptr)) {
      if (gradient != nullptr) gradient->setZero(u.size());
      return undefined_penalty(1);
    }
    if (!values.allFinite()) return undefined_penalty(1);
    if (gradient != nullptr) *gradient = 2 * jacobian.topRows(rows).transpose() * values.head(rows);
    return values.head(rows).squaredNorm();
  };
  NonlinearProgram program;
  program.size = context.scaling.size();
  program.objective = [&](const VectorX& u, VectorX* gradient) {
    return sum_of_squares(u, gradient, equations.row_count);
  };
  const SearchOptions& options = context.problem.search;
  LeastSquaresResult best = start;
  if (evaluations > 0) {
    const VectorX coarse =
        search_globally(options.global, program, start.u,
                        {evaluations, context.budget.remaining_time(), 0, 0, context.budget.make_stop_callback()},
                        options.seed, true)
            .u;
    ++context.budget.local_searches;
    LeastSquaresResult found = solve_levenberg_marquardt(equations, coarse);
    if (found.values.size() > 0 && (best.values.size() == 0 || found.values.squaredNorm() < best.values.squaredNorm()))
      best = std::move(found);
  }
  if (context.is_admissible(best.u)) return best.u;
  // the inequalities were one residual among others: now they are kept
  program.objective = [&](const VectorX& u, VectorX* gradient) { return sum_of_squares(u, gradient, conditions); };
  add_design_inequalities(context, program);
  const VectorX kept =
      search_locally("slsqp", program, context.scaling.start(),
                     {2000, context.budget.remaining_time(), 1e-12, 0, context.budget.make_stop_callback()})
          .u;
  if (context.is_admissible(kept)) return kept;
  double part = 1;
  while (part > 1e-9 && !context.is_admissible(context.scaling.start() + part * (kept - context.scaling.start())))
    part *= 0.9;
  return part > 1e-9 ? VectorX(context.scaling.start() + part * (kept - context.scaling.start()))
                     : context.scaling.start();
}

}  // namespace balance::design
