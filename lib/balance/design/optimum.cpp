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

namespace balance::designing {

namespace {

std::string local_method(const Context& context, const FigureOfMerit& merit) {
  const std::string& asked = context.problem.search.local;
  return asked != "auto" ? asked : merit.simulated() ? "cobyla" : "slsqp";
}

SearchLimits local_limits(const Context& context, const FigureOfMerit& merit) {
  SearchLimits limits;
  limits.evaluations = std::min(context.problem.search.evaluations, 2000);
  limits.seconds = context.budget.left();
  limits.stop = context.budget.stopper();
  limits.step = 0.1;
  if (merit.simulated()) limits.relative = 1e-6;
  return limits;
}

/// Worse than anything worth finding, yet a number that searches can compare.
double penalty(double reference) { return 1e3 * (std::abs(reference) + 1); }

void add_physical(const Context& context, Program& program) {
  program.inequality_count = context.inequalities();
  program.inequalities = [&context](const VectorX& u, VectorX& values, MatrixX* jacobian) {
    context.evaluate_inequalities(u, values, jacobian);
  };
}

/// Conditions that are independent at u; the others follow from them near it.
std::vector<int> independent_rows(const Equations& equations, const VectorX& u) {
  VectorX values;
  MatrixX jacobian;
  std::vector<int> rows;
  if (equations.conditions == 0 || !equations.evaluate(u, values, &jacobian)) return rows;
  ColumnPivotingQr qr(jacobian.topRows(equations.conditions).transpose());
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
      all.setConstant(equations.rows, 1);  // far from met
      slopes.setZero(equations.rows, u.size());
    }
    values = all(rows);
    if (jacobian != nullptr) *jacobian = slopes(rows, Eigen::all);
  };
  add_physical(context, program);
  return search_locally(method, program, start, limits).u;
}

/// Points of the box from which a search of a figure that takes a simulation goes down, besides what is known.
int spread_count(const FigureOfMerit& merit, Eigen::Index size) {
  return merit.simulated() ? std::min(6 + 6 * static_cast<int>(size), 40) : 0;
}

/// Moves in the tangent space of the conditions; every point is brought back onto them.
class TangentSearch {
 public:
  TangentSearch(const Context& context, const FigureOfMerit& merit, const Equations& equations,
                const std::function<VectorX(const VectorX&)>& back)
      : context_(context), merit_(merit), equations_(equations), back_(back) {}

  /// @param others exact too
  /// @param descents 0: polishes only
  VectorX from(const VectorX& start, const std::vector<VectorX>& others, int descents, double step) const {
    const MatrixX tangents = tangent_space(equations_, start);
    if (tangents.cols() == 0) return start;
    const auto point = [&](const VectorX& z) { return back_(clipped(start + tangents * z)); };
    Seek task;
    task.value = [&](const VectorX& z) {
      const VectorX u = point(z);
      return is_exact(context_, equations_, u) ? merit_(u, nullptr) : std::numeric_limits<double>::quiet_NaN();
    };
    task.bound = 2 * std::sqrt(static_cast<double>(start.size()));
    task.starts = {VectorX::Zero(tangents.cols())};
    for (const VectorX& other : others) task.starts.push_back(tangents.transpose() * (other - start));
    const std::string& asked = context_.problem.search.local;
    task.method = asked == "auto" || wants_gradients(asked) ? "cobyla" : asked;
    task.descents = descents;
    task.evaluations = std::min(context_.problem.search.evaluations, merit_.simulated() ? 400 : 2000);
    task.step = step;
    task.finest = merit_.simulated() ? 1e-5 : 1e-4;
    return point(seek(task, context_.budget).u);
  }

 private:
  const Context& context_;
  const FigureOfMerit& merit_;
  const Equations& equations_;
  const std::function<VectorX(const VectorX&)>& back_;
};

/// Keeps the best admissible point.
class Best {
 public:
  explicit Best(const FigureOfMerit& merit) : merit_(merit) {}
  bool consider(const VectorX& u) {
    const double value = merit_(u, nullptr);
    if (!std::isfinite(value) || optimum.value <= value) return false;
    optimum.u = u;
    optimum.value = value;
    return true;
  }
  Optimum optimum{{}, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN(), false};

 private:
  const FigureOfMerit& merit_;
};

/// Where numbers of the motion alone are free besides masses, the figure's slopes by them are known. @return they led somewhere
bool consider_slopes(const Context& context, const FigureOfMerit& merit, const Equations& equations,
                     const std::function<VectorX(const VectorX&)>& back, Best& best) {
  if (!merit.simulated() || context.problem.inner || context.survey.any_geometric()) return false;
  bool any = false;
  for (const VectorX& end : search_two_levels(context, best.optimum.u, &merit, false).balanced)
    if (const VectorX u = back(end); is_exact(context, equations, u)) any = best.consider(u) || any;
  return any;
}

}  // namespace

Optimum best_exact(const Context& context, const FigureOfMerit& merit, const Equations& equations,
                   const std::function<VectorX(const VectorX&)>& back, const std::vector<VectorX>& solutions) {
  const std::string method = local_method(context, merit);
  Best best(merit);
  for (const VectorX& solution : solutions)
    if (is_exact(context, equations, solution)) best.consider(solution);
  if (best.optimum.u.size() == 0) {
    best.optimum.u = solutions.front();
    return best.optimum;
  }
  if (wants_gradients(method)) {
    for (const VectorX& solution : solutions) {
      if (context.budget.spent() || tangent_space(equations, solution).cols() == 0) continue;
      ++context.budget.descents;
      const VectorX u =
          back(with_equalities(context, merit, equations, solution, method, local_limits(context, merit)));
      if (is_exact(context, equations, u)) best.consider(u);
    }
  }
  const auto freedoms = tangent_space(equations, best.optimum.u).cols();
  if (freedoms == 0) return best.optimum;
  const bool slopes = consider_slopes(context, merit, equations, back, best);
  std::vector<VectorX> others = solutions;
  for (const VectorX& u :
       spread_points(slopes ? 0 : spread_count(merit, freedoms), context.box.size(), context.problem.search.seed))
    others.push_back(u);
  const TangentSearch search(context, merit, equations, back);
  const bool only_polish = wants_gradients(method) && !merit.simulated();
  if (only_polish && (freedoms > 8 || context.problem.inner)) return best.optimum;
  // the tangents of a curved set of solutions turn
  int descents = only_polish ? 0 : slopes ? 1 : 3;
  for (double step = 0.1; step > 1e-3 && !context.budget.spent(); step /= 4, descents = std::min(descents, 1)) {
    const VectorX u = search.from(best.optimum.u, descents > 1 ? others : std::vector<VectorX>{}, descents, step);
    if (!is_exact(context, equations, u) || !best.consider(u)) break;
  }
  return best.optimum;
}

namespace {

/// Methods with gradients keep the physical limits as constraints.
VectorX with_limits(const Context& context, const FigureOfMerit& merit, const VectorX& from) {
  Program program;
  program.size = context.box.size();
  program.objective = [&](const VectorX& u, VectorX* gradient) { return merit(u, gradient); };
  add_physical(context, program);
  ++context.budget.descents;
  return search_locally(local_method(context, merit), program, from, local_limits(context, merit)).u;
}

}  // namespace

Optimum best_compromise(const Context& context, const FigureOfMerit& merit, const VectorX& start) {
  const SearchOptions& options = context.problem.search;
  Best best(merit);
  const auto consider = [&](const VectorX& u) {
    if (context.allows(u)) best.consider(u);
  };
  consider(start);
  if (merit.has_pieces() && options.local == "auto" && context.limits->size() == 0) {
    for (const VectorX& u : least_maxima(context, merit, start)) consider(u);
    if (best.optimum.u.size() > 0) return best.optimum;
  }
  const auto value = [&](const VectorX& u) {
    VectorX features;
    context.map.evaluate(u, features, nullptr);
    const bool allowed = context.physical.holds(features) && context.limits->hold(u);
    return allowed ? merit(u, nullptr) : std::numeric_limits<double>::quiet_NaN();
  };
  Program program;
  program.size = context.box.size();
  program.objective = [&](const VectorX& u, VectorX* gradient) {
    const double inside = value(u);
    if (gradient != nullptr) merit(u, gradient);
    ++context.budget.evaluations;
    return inside;
  };
  const int evaluations = merit.simulated() ? std::max(1, options.evaluations / 20) : options.evaluations;
  const SearchLimits limits{evaluations, context.budget.left() / 2, 0, 0, context.budget.stopper()};
  const VectorX coarse =
      context.box.size() > 0
          ? search_globally(options.global, program, start, limits, options.seed, !merit.simulated()).u
          : start;
  consider(coarse);
  if (wants_gradients(local_method(context, merit)))
    for (const VectorX& from : {coarse, start})
      if (std::isfinite(merit(from, nullptr))) consider(with_limits(context, merit, from));
  Seek task;
  task.value = value;
  task.starts = {best.optimum.u.size() > 0 ? best.optimum.u : start, coarse, start};
  for (const VectorX& u : spread_points(spread_count(merit, start.size()), context.box.size(), options.seed))
    task.starts.push_back(u);
  task.method = wants_gradients(local_method(context, merit)) ? "cobyla" : local_method(context, merit);
  task.evaluations = std::min(options.evaluations, merit.simulated() ? 400 : 2000);
  task.finest = merit.simulated() ? 1e-6 : 1e-7;
  const Sought found = seek(task, context.budget);
  consider(found.u);
  if (best.optimum.u.size() == 0) best.optimum.u = start;
  return best.optimum;
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
    if (!values.allFinite()) return penalty(1);
    if (gradient != nullptr) *gradient = 2 * jacobian.topRows(rows).transpose() * values.head(rows);
    return values.head(rows).squaredNorm();
  };
  Program program;
  program.size = context.box.size();
  program.objective = [&](const VectorX& u, VectorX* gradient) { return sum_of_squares(u, gradient, equations.rows); };
  const SearchOptions& options = context.problem.search;
  Descent best = start;
  if (evaluations > 0) {
    const VectorX coarse =
        search_globally(options.global, program, start.u,
                        {evaluations, context.budget.left(), 0, 0, context.budget.stopper()}, options.seed, true)
            .u;
    ++context.budget.descents;
    Descent found = gauss_newton(equations, coarse);
    if (found.values.size() > 0 && (best.values.size() == 0 || found.values.squaredNorm() < best.values.squaredNorm()))
      best = std::move(found);
  }
  if (context.allows(best.u)) return best.u;
  // the inequalities were one residual among others: now they are kept
  program.objective = [&](const VectorX& u, VectorX* gradient) { return sum_of_squares(u, gradient, conditions); };
  add_physical(context, program);
  const VectorX kept = search_locally("slsqp", program, context.box.start(),
                                      {2000, context.budget.left(), 1e-12, 0, context.budget.stopper()})
                           .u;
  if (context.allows(kept)) return kept;
  double part = 1;
  while (part > 1e-9 && !context.allows(context.box.start() + part * (kept - context.box.start()))) part *= 0.9;
  return part > 1e-9 ? VectorX(context.box.start() + part * (kept - context.box.start())) : context.box.start();
}

}  // namespace balance::designing
