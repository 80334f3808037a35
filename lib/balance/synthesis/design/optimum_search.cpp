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

using numerics::NonlinearSystem;

namespace {

/// Limits of the local searches, and the minimum distance between their starts in unit coordinates.
constexpr std::size_t max_epigraph_searches = 4;
constexpr double min_epigraph_start_distance = 0.3;
constexpr int max_epigraph_evaluations = 150;
/// Relative difference below which the ends of two searches from separate starts count as the same minimum.
constexpr double epigraph_optimum_tolerance = 1e-6;

/// Variables: the free numbers, then for each maximum its bound relative to its initial size, minus one.
class EpigraphProgram {
 public:
  EpigraphProgram(const SolverContext& context, const ScaledObjective& objective, const VectorX& from)
      : context_(context), objective_(objective), variable_count_(static_cast<int>(from.size())) {
    evaluate_terms(from);
    if (!max_terms_) return;
    for (std::size_t t = 0; t < max_terms_->size(); ++t) {
      const MaxTerm& term = (*max_terms_)[t];
      objective_scale_ += std::abs(term.weight * numerics::max_coefficient(term.values));
      if (term.values.size() < 2) continue;
      maxima_.push_back({t, static_cast<int>(term.values.size()),
                         std::max(std::abs(numerics::max_coefficient(term.values)), 1e-300)});
      epigraph_row_count_ += maxima_.back().count;
    }
    if (!(objective_scale_ > 0)) objective_scale_ = 1;
  }

  bool has_start_value() const { return max_terms_.has_value(); }

  VectorX start(const VectorX& from) const {
    VectorX v = VectorX::Zero(variable_count_ + static_cast<int>(maxima_.size()));
    v.head(variable_count_) = from;
    return v;
  }

  NonlinearProgram program() {
    NonlinearProgram program;
    program.size = variable_count_ + static_cast<int>(maxima_.size());
    program.objective = [this](const VectorX& v, VectorX* gradient) { return evaluate_objective(v, gradient); };
    program.inequality_count = epigraph_row_count_ + context_.physical_constraints.size();
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

  /// Evaluates all functions at u; caches the last result.
  void evaluate_terms(const VectorX& u) {
    if (last_point_.size() == u.size() && last_point_ == u) return;
    last_point_ = u;
    ++context_.budget.evaluations;
    max_terms_ = objective_.max_terms(u);
    for (const Maximum& maximum : maxima_)
      if (max_terms_ && (*max_terms_)[maximum.term].values.size() != maximum.count) max_terms_.reset();
    if (!max_terms_) return;
    double value = 0;
    for (const MaxTerm& term : *max_terms_) value += term.weight * numerics::max_coefficient(term.values);
    if ((best_ && !(value < best_value_)) || !context_.is_admissible(u)) return;
    best_ = u;
    best_value_ = value;
  }

  double evaluate_objective(const VectorX& v, VectorX* gradient) {
    evaluate_terms(v.head(variable_count_));
    if (!max_terms_) return std::numeric_limits<double>::quiet_NaN();
    double value = 0;
    VectorX slope = VectorX::Zero(v.size());
    for (const MaxTerm& term : *max_terms_)
      if (term.values.size() == 1) {
        value += term.weight * term.values[0];
        slope.head(variable_count_) += term.weight * term.jacobian.row(0).transpose();
      }
    for (std::size_t m = 0; m < maxima_.size(); ++m) {
      const double weight = (*max_terms_)[maxima_[m].term].weight * maxima_[m].size;
      const auto at = variable_count_ + static_cast<Eigen::Index>(m);
      value += weight * (1 + v[at]);
      slope[at] += weight;
    }
    if (gradient != nullptr) *gradient = slope / objective_scale_;
    return value / objective_scale_;
  }

  void evaluate_inequalities(const VectorX& v, VectorX& values, MatrixX* jacobian) {
    evaluate_terms(v.head(variable_count_));
    values.setConstant(epigraph_row_count_ + context_.physical_constraints.size(),
                       std::numeric_limits<double>::quiet_NaN());
    if (jacobian != nullptr) jacobian->setZero(values.size(), v.size());
    if (!max_terms_) return;
    Eigen::Index row = 0;
    for (std::size_t m = 0; m < maxima_.size(); ++m) {
      const MaxTerm& term = (*max_terms_)[maxima_[m].term];
      const auto at = variable_count_ + static_cast<Eigen::Index>(m);
      const int count = maxima_[m].count;
      values.segment(row, count) = (1 + v[at]) - term.values.array() / maxima_[m].size;
      if (jacobian != nullptr) {
        jacobian->block(row, 0, count, variable_count_) = -term.jacobian / maxima_[m].size;
        jacobian->col(at).segment(row, count).setOnes();
      }
      row += count;
    }
    VectorX features, physical;
    MatrixX slopes, physical_slopes;
    context_.features.evaluate(v.head(variable_count_), features, jacobian != nullptr ? &slopes : nullptr);
    context_.physical_constraints.evaluate(features, &slopes, physical,
                                           jacobian != nullptr ? &physical_slopes : nullptr);
    values.tail(context_.physical_constraints.size()) = physical;
    if (jacobian != nullptr)
      jacobian->bottomLeftCorner(context_.physical_constraints.size(), variable_count_) = physical_slopes;
  }

  const SolverContext& context_;
  const ScaledObjective& objective_;
  int variable_count_, epigraph_row_count_ = 0;
  std::vector<Maximum> maxima_;
  double objective_scale_ = 0;
  VectorX last_point_;
  std::optional<std::vector<MaxTerm>> max_terms_;
  std::optional<VectorX> best_;
  double best_value_ = 0;
};

/// Whether the two best results agree.
bool has_repeated_optimum(std::vector<std::pair<double, VectorX>> ends) {
  if (ends.size() < 2) return false;
  std::sort(ends.begin(), ends.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  return ends[1].first - ends[0].first <= epigraph_optimum_tolerance * std::abs(ends[0].first);
}

}  // namespace

std::optional<VectorX> minimise_max_terms_from(const SolverContext& context, const ScaledObjective& objective,
                                               const VectorX& from) {
  EpigraphProgram epigraph(context, objective, from);
  if (!epigraph.has_start_value()) return std::nullopt;
  ++context.budget.local_searches;
  const StoppingCriteria limits{std::min(context.problem.search.max_evaluations, max_epigraph_evaluations),
                                context.budget.remaining_time(), 1e-8, 0};
  if (search_locally("slsqp", epigraph.program(), epigraph.start(from), limits).is_budget_exhausted &&
      context.budget.is_spent())
    context.budget.stopped = true;
  return epigraph.best();
}

std::vector<VectorX> minimise_max_terms(const SolverContext& context, const ScaledObjective& objective,
                                        const VectorX& start) {
  const int size = static_cast<int>(start.size());
  std::vector<std::pair<double, VectorX>> points;
  const auto evaluate = [&](const VectorX& u) {
    if (points.empty() || !context.budget.is_spent())
      if (const double value = objective(u, nullptr); std::isfinite(value)) points.emplace_back(value, u);
  };
  evaluate(start);
  const std::size_t from_start = points.size();
  for (const VectorX& u : low_discrepancy_points(8 + 2 * size, size, context.problem.search.seed)) evaluate(u);
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
    if (const auto end = minimise_max_terms_from(context, objective, u))
      ends.emplace_back(objective(*end, nullptr), *end);
  }
  std::stable_sort(ends.begin(), ends.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<VectorX> optima;
  for (auto& [value, u] : ends)
    if (std::isfinite(value)) optima.push_back(std::move(u));
  return optima;
}

namespace {

std::string choose_local_method(const SolverContext& context, const ScaledObjective& objective) {
  const std::string& requested_method = context.problem.search.local;
  return requested_method != "auto" ? requested_method : objective.is_simulated() ? "cobyla" : "slsqp";
}

StoppingCriteria make_stopping_criteria(const SolverContext& context, const ScaledObjective& objective) {
  StoppingCriteria limits;
  limits.max_evaluations = std::min(context.problem.search.max_evaluations, 2000);
  limits.max_time = context.budget.remaining_time();
  limits.stop = context.budget.make_stop_callback();
  limits.initial_step = 0.1;
  if (objective.is_simulated()) limits.relative_tolerance = 1e-6;
  return limits;
}

/// Finite substitute for undefined values, worse than any useful one.
double undefined_penalty(double reference) { return 1e3 * (std::abs(reference) + 1); }

void add_design_inequalities(const SolverContext& context, NonlinearProgram& program) {
  program.inequality_count = context.inequality_count();
  program.inequalities = [&context](const VectorX& u, VectorX& values, MatrixX* jacobian) {
    context.evaluate_inequalities(u, values, jacobian);
  };
}

/// Conditions that are independent at u; near u they imply the others.
std::vector<int> independent_rows(const NonlinearSystem& equations, const VectorX& u) {
  VectorX values;
  MatrixX jacobian;
  std::vector<int> rows;
  if (equations.primary_rows == 0 || !equations.evaluate(u, values, &jacobian)) return rows;
  numerics::ColumnPivotingQr qr(jacobian.topRows(equations.primary_rows).transpose());
  qr.setThreshold(1e-9);
  for (Eigen::Index k = 0; k < qr.rank(); ++k) rows.push_back(qr.colsPermutation().indices()[k]);
  std::sort(rows.begin(), rows.end());
  return rows;
}

/// Uses a gradient-based method with the conditions as equalities.
VectorX optimise_with_equalities(const SolverContext& context, const ScaledObjective& objective,
                                 const NonlinearSystem& equations, const VectorX& start, const std::string& method,
                                 const StoppingCriteria& limits) {
  NonlinearProgram program;
  program.size = context.scaling.size();
  VectorX slope;
  const double value = std::abs(objective(start, &slope)), steepest = numerics::max_abs(slope);
  // Scales the objective to order one, like the conditions; otherwise its unit would affect the termination.
  const double size = std::isfinite(value + steepest) && value + steepest > 0 ? std::max(value, steepest) : 1;
  program.objective = [&objective, size](const VectorX& u, VectorX* gradient) {
    const double scaled_value = objective(u, gradient) / size;
    if (gradient != nullptr) *gradient /= size;
    return scaled_value;
  };
  const std::vector<int> rows = independent_rows(equations, start);
  program.equality_count = static_cast<int>(rows.size());
  program.equalities = [&](const VectorX& u, VectorX& values, MatrixX* jacobian) {
    VectorX all;
    MatrixX slopes;
    if (!equations.evaluate(u, all, jacobian != nullptr ? &slopes : nullptr)) {
      all.setConstant(equations.row_count, 1);  // clearly unmet
      slopes.setZero(equations.row_count, u.size());
    }
    values = all(rows);
    if (jacobian != nullptr) *jacobian = slopes(rows, Eigen::all);
  };
  add_design_inequalities(context, program);
  return search_locally(method, program, start, limits).u;
}

/// Number of additional space-filling starts for figures that require a simulation.
int count_start_points(const ScaledObjective& objective, Eigen::Index size) {
  return objective.is_simulated() ? std::min(6 + 6 * static_cast<int>(size), 40) : 0;
}

/// Searches in the tangent space of the conditions; every point is projected back onto them.
class TangentSpaceSearch {
 public:
  TangentSpaceSearch(const SolverContext& context, const ScaledObjective& objective, const NonlinearSystem& equations,
                     const std::function<VectorX(const VectorX&)>& restore)
      : context_(context), objective_(objective), equations_(equations), restore_(restore) {}

  /// @param others also exact
  /// @param descents number of local searches; 0: polish only
  VectorX search_from(const VectorX& start, const std::vector<VectorX>& others, int descents, double step) const {
    const MatrixX tangents = tangent_space(equations_, start);
    if (tangents.cols() == 0) return start;
    const auto point = [&](const VectorX& z) { return restore_(clip_to_unit_box(start + tangents * z)); };
    MultistartSettings settings;
    settings.objective = [&](const VectorX& z) {
      const VectorX u = point(z);
      return is_exact(context_, equations_, u) ? objective_(u, nullptr) : std::numeric_limits<double>::quiet_NaN();
    };
    settings.bound = 2 * std::sqrt(static_cast<double>(start.size()));
    settings.starts = {VectorX::Zero(tangents.cols())};
    for (const VectorX& other : others) settings.starts.push_back(tangents.transpose() * (other - start));
    const std::string& requested_method = context_.problem.search.local;
    settings.method = requested_method == "auto" || is_gradient_based(requested_method) ? "cobyla" : requested_method;
    settings.max_local_searches = descents;
    settings.max_evaluations =
        std::min(context_.problem.search.max_evaluations, objective_.is_simulated() ? 400 : 2000);
    settings.initial_step = step;
    settings.min_step = objective_.is_simulated() ? 1e-5 : 1e-4;
    return point(search_multistart(settings, context_.budget).u);
  }

 private:
  const SolverContext& context_;
  const ScaledObjective& objective_;
  const NonlinearSystem& equations_;
  const std::function<VectorX(const VectorX&)>& restore_;
};

/// Keeps the best point.
class BestPoint {
 public:
  explicit BestPoint(const ScaledObjective& objective) : objective_(objective) {}
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

/// If motion variables are free besides masses, uses the known gradient of the figure. @return whether the figure was
/// improved
bool try_bilevel_search(const SolverContext& context, const ScaledObjective& objective,
                        const NonlinearSystem& equations, const std::function<VectorX(const VectorX&)>& restore,
                        BestPoint& best) {
  if (!objective.is_simulated() || context.problem.is_subproblem || context.classification.has_geometric())
    return false;
  bool is_improved = false;
  for (const VectorX& end : search_bilevel(context, best.optimum.u, &objective, false).balanced)
    if (const VectorX u = restore(end); is_exact(context, equations, u)) is_improved = best.consider(u) || is_improved;
  return is_improved;
}

}  // namespace

VectorX minimise_along_conditions(const SolverContext& context, const ScaledObjective& objective,
                                  const NonlinearSystem& equations, const VectorX& start) {
  ++context.budget.local_searches;
  return optimise_with_equalities(context, objective, equations, start, "slsqp",
                                  make_stopping_criteria(context, objective));
}

Optimum optimise_exact_solutions(const SolverContext& context, const ScaledObjective& objective,
                                 const NonlinearSystem& equations,
                                 const std::function<VectorX(const VectorX&)>& restore,
                                 const std::vector<VectorX>& solutions) {
  const std::string method = choose_local_method(context, objective);
  BestPoint best(objective);
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
      const VectorX u = restore(optimise_with_equalities(context, objective, equations, solution, method,
                                                         make_stopping_criteria(context, objective)));
      if (is_exact(context, equations, u)) best.consider(u);
    }
  }
  const auto dimension = tangent_space(equations, best.optimum.u).cols();
  if (dimension == 0) return best.optimum;
  const bool is_improved_by_gradients = try_bilevel_search(context, objective, equations, restore, best);
  std::vector<VectorX> others = solutions;
  for (const VectorX& u :
       low_discrepancy_points(is_improved_by_gradients ? 0 : count_start_points(objective, dimension),
                              context.scaling.size(), context.problem.search.seed))
    others.push_back(u);
  const TangentSpaceSearch search(context, objective, equations, restore);
  const bool only_polish = is_gradient_based(method) && !objective.is_simulated();
  if (only_polish && (dimension > 8 || context.problem.is_subproblem)) return best.optimum;
  // The tangent space of a curved solution set changes from point to point.
  int descents = only_polish ? 0 : is_improved_by_gradients ? 1 : 3;
  for (double step = 0.1; step > 1e-3 && !context.budget.is_spent(); step /= 4, descents = std::min(descents, 1)) {
    const VectorX u =
        search.search_from(best.optimum.u, descents > 1 ? others : std::vector<VectorX>{}, descents, step);
    if (!is_exact(context, equations, u) || !best.consider(u)) break;
  }
  return best.optimum;
}

namespace {

/// The best point at which both the objective and the inequalities of a search were evaluated and all are satisfied.
class FeasiblePoints {
 public:
  void record_value(const VectorX& u, double value) {
    value_ = {u, value};
    compare();
  }
  /// @param margin of the worst inequality
  void record_margin(const VectorX& u, double margin) {
    margin_ = {u, margin};
    compare();
  }
  const VectorX& best() const { return best_.first; }
  double best_value() const { return best_.second; }

 private:
  void compare() {
    const bool is_complete = value_.first.size() > 0 && value_.first.size() == margin_.first.size();
    if (!is_complete || value_.first != margin_.first || !(margin_.second >= 0)) return;
    if (best_.first.size() == 0 || value_.second < best_.second) best_ = value_;
  }

  std::pair<VectorX, double> value_, margin_, best_;
};

/// Gradient-based methods treat physical constraints and limits as inequalities.
/// @return the best point within the limits, or, if there is none, where the search ended
VectorX optimise_with_inequalities(const SolverContext& context, const ScaledObjective& objective,
                                   const VectorX& from) {
  NonlinearProgram program;
  program.size = context.scaling.size();
  FeasiblePoints feasible;
  program.objective = [&](const VectorX& u, VectorX* gradient) {
    const double value = objective(u, gradient);
    feasible.record_value(u, value);
    return value;
  };
  add_design_inequalities(context, program);
  program.inequalities = [&, evaluate = program.inequalities](const VectorX& u, VectorX& values, MatrixX* jacobian) {
    evaluate(u, values, jacobian);
    feasible.record_margin(u, values.size() > 0 ? numerics::min_coefficient(values) : 0);
  };
  ++context.budget.local_searches;
  const VectorX end =
      search_locally(choose_local_method(context, objective), program, from, make_stopping_criteria(context, objective))
          .u;
  if (feasible.best().size() == 0) return end;
  return context.is_admissible(end) && objective(end, nullptr) <= feasible.best_value() ? end : feasible.best();
}

}  // namespace

VectorX minimise_within_limits(const SolverContext& context, const ScaledObjective& objective, const VectorX& start) {
  BestPoint best(objective);
  for (const VectorX& u : {start, optimise_with_inequalities(context, objective, start)})
    if (context.is_admissible(u)) best.consider(u);
  return best.optimum.u.size() > 0 ? best.optimum.u : start;
}

Optimum optimise_compromise(const SolverContext& context, const ScaledObjective& objective, const VectorX& start) {
  const study::SearchOptions& options = context.problem.search;
  BestPoint best(objective);
  const auto consider = [&](const VectorX& u) {
    if (context.is_admissible(u)) best.consider(u);
  };
  consider(start);
  if (objective.has_max_terms() && options.local == "auto" && context.limits->size() == 0) {
    for (const VectorX& u : minimise_max_terms(context, objective, start)) consider(u);
    if (best.optimum.u.size() > 0) return best.optimum;
  }
  const auto value = [&](const VectorX& u) {
    VectorX features;
    context.features.evaluate(u, features, nullptr);
    const bool allowed = context.physical_constraints.is_satisfied(features) && context.limits->is_satisfied(u);
    return allowed ? objective(u, nullptr) : std::numeric_limits<double>::quiet_NaN();
  };
  NonlinearProgram program;
  program.size = context.scaling.size();
  program.objective = [&](const VectorX& u, VectorX* gradient) {
    const double inside = value(u);
    if (gradient != nullptr) objective(u, gradient);
    ++context.budget.evaluations;
    return inside;
  };
  const int evaluations =
      objective.is_simulated() ? std::max(1, options.max_evaluations / 20) : options.max_evaluations;
  const auto descend_from = [&](const VectorX& from) {
    if (is_gradient_based(choose_local_method(context, objective)) && std::isfinite(objective(from, nullptr)))
      consider(optimise_with_inequalities(context, objective, from));
  };
  descend_from(start);
  const StoppingCriteria limits{evaluations, context.budget.remaining_time(), 0, 0,
                                context.budget.make_stop_callback()};
  const VectorX coarse =
      context.scaling.size() > 0
          ? search_globally(options.global, program, start, limits, options.seed, !objective.is_simulated()).u
          : start;
  consider(coarse);
  descend_from(coarse);
  MultistartSettings settings;
  settings.objective = value;
  settings.starts = {best.optimum.u.size() > 0 ? best.optimum.u : start, coarse, start};
  for (const VectorX& u :
       low_discrepancy_points(count_start_points(objective, start.size()), context.scaling.size(), options.seed))
    settings.starts.push_back(u);
  settings.method =
      is_gradient_based(choose_local_method(context, objective)) ? "cobyla" : choose_local_method(context, objective);
  settings.max_evaluations = std::min(options.max_evaluations, objective.is_simulated() ? 400 : 2000);
  settings.min_step = objective.is_simulated() ? 1e-6 : 1e-7;
  const MultistartResult result = search_multistart(settings, context.budget);
  consider(result.u);
  if (best.optimum.u.size() == 0) best.optimum.u = start;
  return best.optimum;
}

VectorX minimise_residual(const SolverContext& context, const NonlinearSystem& equations,
                          const numerics::LeastSquaresResult& start, int evaluations) {
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
  const study::SearchOptions& options = context.problem.search;
  numerics::LeastSquaresResult best = start;
  if (evaluations > 0) {
    const VectorX coarse =
        search_globally(options.global, program, start.u,
                        {evaluations, context.budget.remaining_time(), 0, 0, context.budget.make_stop_callback()},
                        options.seed, true)
            .u;
    ++context.budget.local_searches;
    numerics::LeastSquaresResult descent = solve_levenberg_marquardt(equations, coarse);
    if (descent.values.size() > 0 &&
        (best.values.size() == 0 || descent.values.squaredNorm() < best.values.squaredNorm()))
      best = std::move(descent);
  }
  if (context.is_admissible(best.u)) return best.u;
  // So far the inequalities were only penalised; now they are constraints.
  program.objective = [&](const VectorX& u, VectorX* gradient) { return sum_of_squares(u, gradient, conditions); };
  add_design_inequalities(context, program);
  const VectorX feasible_point =
      search_locally("slsqp", program, context.scaling.start(),
                     {2000, context.budget.remaining_time(), 1e-12, 0, context.budget.make_stop_callback()})
          .u;
  if (context.is_admissible(feasible_point)) return feasible_point;
  double fraction = 1;
  while (fraction > 1e-9 &&
         !context.is_admissible(context.scaling.start() + fraction * (feasible_point - context.scaling.start())))
    fraction *= 0.9;
  return fraction > 1e-9 ? VectorX(context.scaling.start() + fraction * (feasible_point - context.scaling.start()))
                         : context.scaling.start();
}

}  // namespace balance::design
