#include "balance/synthesis/design/optimum_search.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/synthesis/design/bilevel_search.hpp"
#include "balance/synthesis/design/multistart.hpp"
#include "balance/synthesis/design/nlopt_search.hpp"
#include "balance/synthesis/design/problem_functions.hpp"
#include "balance/synthesis/design/solve_design.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace balance::design {

namespace {

/// Local searches, from points no nearer to each other than this in unit coordinates.
constexpr std::size_t max_epigraph_searches = 4;
constexpr double min_epigraph_start_distance = 0.3;
constexpr int max_epigraph_evaluations = 150;
/// Two ends from points apart, neither of which is better by more than this part, are one minimum that is not to be doubted.
constexpr double epigraph_optimum_tolerance = 1e-6;

/// The free numbers, then per maximum its bound, in units of what it is to begin with and less one.
class EpigraphProgram {
 public:
  EpigraphProgram(const SolverContext& context, const ScaledObjective& merit, const VectorX& from)
      : context_(context), objective_(merit), size_(static_cast<int>(from.size())) {
    evaluate_terms(from);
    if (!here_) return;
    for (std::size_t t = 0; t < here_->size(); ++t) {
      const MaxTerm& term = (*here_)[t];
      total_ += std::abs(term.weight * max_coefficient(term.values));
      if (term.values.size() < 2) continue;
      maxima_.push_back(
          {t, static_cast<int>(term.values.size()), std::max(std::abs(max_coefficient(term.values)), 1e-300)});
      rows_ += maxima_.back().count;
    }
    if (!(total_ > 0)) total_ = 1;
  }

  bool has_start_value() const { return here_.has_value(); }

  VectorX start(const VectorX& from) const {
    VectorX v = VectorX::Zero(size_ + static_cast<int>(maxima_.size()));
    v.head(size_) = from;
    return v;
  }

  NonlinearProgram program() {
    NonlinearProgram program;
    program.size = size_ + static_cast<int>(maxima_.size());
    program.objective = [this](const VectorX& v, VectorX* gradient) { return evaluate_objective(v, gradient); };
    program.inequality_count = rows_ + context_.physical_constraints.size();
    program.inequalities = [this](const VectorX& v, VectorX& values, MatrixX* jacobian) {
      evaluate_inequalities(v, values, jacobian);
    };
    return program;
  }

  const std::optional<VectorX>& best() const { return best_; }

 private:
  /// A maximum of several functions.
  struct Maximum {
    std::size_t term;
    int count;
    double size;
  };

  /// What all functions are at the numbers; remembered.
  void evaluate_terms(const VectorX& u) {
    if (known_.size() == u.size() && known_ == u) return;
    known_ = u;
    ++context_.budget.evaluations;
    here_ = objective_.max_terms(u);
    for (const Maximum& maximum : maxima_)
      if (here_ && (*here_)[maximum.term].values.size() != maximum.count) here_.reset();
    if (!here_) return;
    double value = 0;
    for (const MaxTerm& term : *here_) value += term.weight * max_coefficient(term.values);
    if ((best_ && !(value < least_)) || !context_.is_admissible(u)) return;
    best_ = u;
    least_ = value;
  }

  double evaluate_objective(const VectorX& v, VectorX* gradient) {
    evaluate_terms(v.head(size_));
    if (!here_) return std::numeric_limits<double>::quiet_NaN();
    double value = 0;
    VectorX slope = VectorX::Zero(v.size());
    for (const MaxTerm& term : *here_)
      if (term.values.size() == 1) {
        value += term.weight * term.values[0];
        slope.head(size_) += term.weight * term.jacobian.row(0).transpose();
      }
    for (std::size_t m = 0; m < maxima_.size(); ++m) {
      const double weight = (*here_)[maxima_[m].term].weight * maxima_[m].size;
      const auto at = size_ + static_cast<Eigen::Index>(m);
      value += weight * (1 + v[at]);
      slope[at] += weight;
    }
    if (gradient != nullptr) *gradient = slope / total_;
    return value / total_;
  }

  void evaluate_inequalities(const VectorX& v, VectorX& values, MatrixX* jacobian) {
    evaluate_terms(v.head(size_));
    values.setConstant(rows_ + context_.physical_constraints.size(), std::numeric_limits<double>::quiet_NaN());
    if (jacobian != nullptr) jacobian->setZero(values.size(), v.size());
    if (!here_) return;
    Eigen::Index row = 0;
    for (std::size_t m = 0; m < maxima_.size(); ++m) {
      const MaxTerm& term = (*here_)[maxima_[m].term];
      const auto at = size_ + static_cast<Eigen::Index>(m);
      const int count = maxima_[m].count;
      values.segment(row, count) = (1 + v[at]) - term.values.array() / maxima_[m].size;
      if (jacobian != nullptr) {
        jacobian->block(row, 0, count, size_) = -term.jacobian / maxima_[m].size;
        jacobian->col(at).segment(row, count).setOnes();
      }
      row += count;
    }
    VectorX features, physical;
    MatrixX slopes, physical_slopes;
    context_.features.evaluate(v.head(size_), features, jacobian != nullptr ? &slopes : nullptr);
    context_.physical_constraints.evaluate(features, &slopes, physical,
                                           jacobian != nullptr ? &physical_slopes : nullptr);
    values.tail(context_.physical_constraints.size()) = physical;
    if (jacobian != nullptr) jacobian->bottomLeftCorner(context_.physical_constraints.size(), size_) = physical_slopes;
  }

  const SolverContext& context_;
  const ScaledObjective& objective_;
  int size_, rows_ = 0;
  std::vector<Maximum> maxima_;
  double total_ = 0;
  VectorX known_;
  std::optional<std::vector<MaxTerm>> here_;
  std::optional<VectorX> best_;
  double least_ = 0;
};

/// The two best ends are as good as each other.
bool has_repeated_optimum(std::vector<std::pair<double, VectorX>> ends) {
  if (ends.size() < 2) return false;
  std::sort(ends.begin(), ends.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  return ends[1].first - ends[0].first <= epigraph_optimum_tolerance * std::abs(ends[0].first);
}

}  // namespace

std::optional<VectorX> minimise_max_terms_from(const SolverContext& context, const ScaledObjective& merit,
                                               const VectorX& from) {
  EpigraphProgram epigraph(context, merit, from);
  if (!epigraph.has_start_value()) return std::nullopt;
  ++context.budget.local_searches;
  const StoppingCriteria limits{std::min(context.problem.search.max_evaluations, max_epigraph_evaluations),
                                context.budget.remaining_time(), 1e-8, 0};
  if (search_locally("slsqp", epigraph.program(), epigraph.start(from), limits).is_budget_exhausted &&
      context.budget.is_spent())
    context.budget.stopped = true;
  return epigraph.best();
}

std::vector<VectorX> minimise_max_terms(const SolverContext& context, const ScaledObjective& merit,
                                        const VectorX& start) {
  const int size = static_cast<int>(start.size());
  std::vector<std::pair<double, VectorX>> points;
  const auto look = [&](const VectorX& u) {
    if (points.empty() || !context.budget.is_spent())
      if (const double value = merit(u, nullptr); std::isfinite(value)) points.emplace_back(value, u);
  };
  look(start);
  const std::size_t from_start = points.size();
  for (const VectorX& u : low_discrepancy_points(8 + 2 * size, size, context.problem.search.seed)) look(u);
  std::stable_sort(points.begin() + static_cast<std::ptrdiff_t>(from_start), points.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<VectorX> used;
  std::vector<std::pair<double, VectorX>> ends;
  for (const auto& [value, u] : points) {
    if (used.size() >= max_epigraph_searches || context.budget.is_spent() || has_repeated_optimum(ends)) break;
    if (std::any_of(used.begin(), used.end(),
                    [&, &u = u](const VectorX& v) { return (u - v).norm() < min_epigraph_start_distance; }))
      continue;
    used.push_back(u);
    if (const auto end = minimise_max_terms_from(context, merit, u)) ends.emplace_back(merit(*end, nullptr), *end);
  }
  std::stable_sort(ends.begin(), ends.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<VectorX> found;
  for (auto& [value, u] : ends)
    if (std::isfinite(value)) found.push_back(std::move(u));
  return found;
}

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
