#include "balance/synthesis/design/geometry_search.hpp"

#include "balance/foundation/base/cpu_time.hpp"
#include "balance/foundation/base/error.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/synthesis/design/bilevel_search.hpp"
#include "balance/synthesis/design/condition_equations.hpp"
#include "balance/synthesis/design/derived_problems.hpp"
#include "balance/synthesis/design/multistart.hpp"
#include "balance/synthesis/design/optimum_search.hpp"
#include "balance/synthesis/design/problem_functions.hpp"
#include "balance/synthesis/design/solve_design.hpp"
#include "balance/synthesis/design/start_agreement.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

namespace balance::design {

using numerics::NonlinearSystem;

/// A design at one geometry, and the comparison of several.
struct TrialDesign {
  VectorX u;                 ///< all variables
  bool is_feasible = false;  ///< physical, can be assembled and follows the required motions
  bool is_balanced = false;
  double figure = std::numeric_limits<double>::quiet_NaN();  ///< the objective
  double residual =
      std::numeric_limits<double>::quiet_NaN();  ///< norm of the goal's residual at the samples of the equations
};

class TrialEvaluator {
 public:
  /// @param equations of the goal; may be empty
  /// @param objective nullptr: no objective
  TrialEvaluator(const SolverContext& context, const NonlinearSystem& equations, const ScaledObjective* objective);

  /// Whether the objective takes priority over the conditions if these cannot be met.
  bool is_figure_first() const { return objective_ != nullptr && !context_.problem.objective->is_secondary; }
  /// Compares balanced designs by the objective and others by the objective or the residual; keep_better prefers
  /// balanced ones.
  double cost(const TrialDesign& trial) const;
  void keep_better(TrialDesign& best, TrialDesign trial) const;

  /// Whether the conditions, derived anew at the geometry of u, are met.
  bool is_balanced(const VectorX& u) const;
  /// Evaluates u without changing it.
  TrialDesign evaluate(const VectorX& u) const;
  /// Keeps the lengths of u and solves for the other variables.
  TrialDesign solve_at_geometry(const VectorX& u) const;

 private:
  void evaluate_figures(TrialDesign& trial) const;

  const SolverContext& context_;
  const NonlinearSystem& equations_;
  const ScaledObjective* objective_;
  std::vector<int> inertial_variables_;  ///< variables that do not change the geometry
};

namespace {

/// Maximum number of points tested as anchor.
constexpr int max_start_samples = 200;
/// Distance, relative to half of a length's range, within which a length is tentatively snapped to a special ratio.
constexpr double length_ratio_tolerance = 1e-5;

}  // namespace

std::optional<VectorX> find_feasible_start(const SolverContext& context, std::string& reason) {
  const auto has_conditions = [&](const VectorX& u, std::string& failure) {
    failure = context.infeasibility_reason(u);
    if (!failure.empty()) return false;
    const Conditions conditions = context.conditions_at(u);
    if (conditions.status != ConditionsStatus::done) failure = conditions.reason;
    return conditions.status == ConditionsStatus::done;
  };
  const VectorX start = context.scaling.start();
  if (has_conditions(start, reason)) return start;
  // Points near the start first; the other variables keep their start values.
  const std::vector<int> lengths = geometric_variables(context);
  const auto points =
      low_discrepancy_points(max_start_samples, static_cast<int>(lengths.size()), context.problem.search.seed);
  for (std::size_t k = 0; k < points.size() && !context.budget.is_spent(); ++k) {
    VectorX u = start;
    const double fraction = static_cast<double>(k + 1) / static_cast<double>(points.size());
    for (std::size_t i = 0; i < lengths.size(); ++i)
      u[lengths[i]] = std::clamp(
          start[lengths[i]] + fraction * (points[k][static_cast<Eigen::Index>(i)] - start[lengths[i]]), -1.0, 1.0);
    std::string failure;
    if (has_conditions(u, failure)) return u;
  }
  return std::nullopt;
}

std::optional<VectorX> snap_to_length_ratios(const SolverContext& context, const VectorX& u) {
  const VectorX geometry = collect_condition_geometry(context.mechanism(u), context.options);
  const VectorX x = context.scaling.to_variables(u);
  VectorX moved = u;
  for (const int i : geometric_variables(context)) {
    const double half = context.scaling.half_width()[i];
    double nearest = length_ratio_tolerance * half;
    if (!(half > 0)) continue;
    for (const double length : geometry)
      for (const double ratio : {1.0, 2.0, 0.5, 1.5, 2.0 / 3, 3.0, 1.0 / 3, 4.0 / 3, 0.75}) {
        const double deviation = std::abs(std::abs(length) * ratio - std::abs(x[i]));
        // `geometry` contains the number itself
        if (deviation >= nearest || deviation <= 1e-15 * std::abs(x[i])) continue;
        nearest = deviation;
        moved[i] =
            std::clamp((std::copysign(std::abs(length) * ratio, x[i]) - context.scaling.centre()[i]) / half, -1.0, 1.0);
      }
  }
  return moved == u ? std::nullopt : std::optional<VectorX>(moved);
}

namespace {

constexpr double no_value = std::numeric_limits<double>::quiet_NaN();
/// Maximum number of exact designs whose lengths are examined, and of starts for the joint search besides the anchor.
constexpr int max_exact_designs = 4, max_joint_starts = 12;
/// Step in unit coordinates for testing whether designs exist at neighbouring lengths.
constexpr double neighbour_offset = 1e-3;

class GeometrySearch {
 public:
  GeometrySearch(const SolverContext& context, const VectorX& anchor, const NonlinearSystem& equations,
                 const ScaledObjective* objective)
      : context_(context),
        anchor_(anchor),
        equations_(equations),
        objective_(objective),
        evaluator_(context, equations, objective),
        geometric_variables_(geometric_variables(context)),
        inertial_variables_(inertial_variables(context)) {}

  GeometrySearchResult run() {
    TrialDesign best;
    const TrialDesign start = context_.is_admissible(anchor_) ? evaluator_.evaluate(anchor_) : TrialDesign{};
    is_compromise_prepared_ = start.is_balanced;
    const bool is_bilevel_applicable = try_bilevel_search(best);
    prepare_compromise(best);
    if (!best.is_balanced)
      for (const VectorX& u : find_exact_designs()) {
        evaluate_candidate(best, u);
        if (objective_ == nullptr && best.is_balanced) break;
      }
    evaluator_.keep_better(best, start);
    if (!best.is_balanced) evaluator_.keep_better(best, solve_at_samples());
    if (objective_ != nullptr && best.is_balanced) {
      const double before = best.figure;
      best =
          improve_geometry(best, is_bilevel_applicable && context_.problem.model->capabilities().are_all_limits_convex);
      // the starts that ended at the same design would be improved alike
      for (double& end : context_.budget.ends)
        if (end - before <= start_agreement_tolerance * std::abs(before)) end = best.figure;
    }
    if (!best.is_balanced) best = search_compromise(best);
    if (best.is_feasible && equations_.primary_rows == 0 && context_.limits->size() == 0) search_all_variables(best);
    return report(best);
  }

 private:
  /// @return whether the bilevel search applies to the problem
  bool try_bilevel_search(TrialDesign& best) {
    const auto handle_start_end = [&](const VectorX& u, bool is_balanced) {
      TrialDesign end;
      if (u.size() > 0 && context_.infeasibility_reason(u).empty()) end = finish_start(u, is_balanced);
      evaluator_.keep_better(best, end);
      if (objective_ == nullptr) return false;
      std::vector<double>& ends = context_.budget.ends;
      ends.push_back(end.is_balanced ? end.figure : no_value);
      prepare_compromise(best);
      return static_cast<int>(ends.size()) >= context_.problem.search.max_restarts ||
             (best.is_balanced && compare_starts(ends, best.figure).is_reached());
    };
    const BilevelResult designs = search_bilevel(context_, anchor_, objective_, false, handle_start_end);
    for (const VectorX& u : designs.balanced) {
      if (best.is_balanced) break;
      const bool is_late = context_.budget.is_spent();
      if (is_late) context_.budget.finish_search();  // the best start shall give a design although the time is over
      if (context_.infeasibility_reason(u).empty()) evaluator_.keep_better(best, finish_start(u, true));
      if (!is_late) continue;
      context_.budget.begin_search();
      break;
    }
    unbalanced_candidates_ = designs.others;
    return designs.is_applicable;
  }

  /// Makes the end of a start exact and, where that costs some of the objective, optimal again.
  TrialDesign finish_start(const VectorX& u, bool is_balanced) {
    TrialDesign end = evaluator_.evaluate(u);
    if (!is_balanced) return end;
    const double relaxed_figure = end.figure;
    if (!end.is_balanced) evaluate_candidate(end, restore_exactly(u));
    if (!end.is_balanced && objective_ != nullptr && equations_.primary_rows == 0)
      evaluator_.keep_better(end, evaluator_.evaluate(minimise_within_limits(context_, *objective_, u)));
    if (objective_ == nullptr || !end.is_balanced) return end;
    if (!objective_->is_simulated() && equations_.primary_rows > 0) descend(end);
    if (end.figure <= relaxed_figure + start_agreement_tolerance / 10 * std::abs(relaxed_figure))
      tight_figure_ = std::min(tight_figure_, end.figure);
    else
      improve_exactly(end);
    return end;
  }

  /// Meets the conditions near u, if possible without the numbers that the objective depends on.
  VectorX restore_exactly(const VectorX& u) const {
    if (equations_.primary_rows == 0) return u;
    const NonlinearSystem equations = make_equations_near(context_, u, equations_);
    std::vector<int> neutral;
    VectorX slope = VectorX::Zero(u.size());
    if (objective_ != nullptr) (*objective_)(u, &slope);
    for (int i = 0; i < u.size(); ++i)
      if (slope[i] == 0) neutral.push_back(i);
    if (!neutral.empty() && static_cast<Eigen::Index>(neutral.size()) < u.size()) {
      const VectorX restored = solve_for(equations, neutral, u).u;
      if (is_exact(context_, equations, restored)) return restored;
    }
    return solve_levenberg_marquardt(equations, u).u;
  }

  /// Levenberg–Marquardt on some of the variables.
  static numerics::LeastSquaresResult solve_for(const NonlinearSystem& equations, const std::vector<int>& variables,
                                                const VectorX& u, int iterations = 100) {
    numerics::LeastSquaresResult result =
        solve_levenberg_marquardt(restrict_to_variables(equations, variables, u), u(variables), iterations);
    VectorX all = u;
    all(variables) = result.u;
    result.u = std::move(all);
    return result;
  }

  /// A descent on all variables at once.
  void descend(TrialDesign& best) const {
    const NonlinearSystem equations = make_equations_near(context_, best.u, equations_);
    const VectorX u = minimise_along_conditions(context_, *objective_, equations, best.u);
    evaluator_.keep_better(best, evaluator_.evaluate(restore_exactly(u)));
  }

  /// Minimises the objective on all variables, with the conditions as equalities.
  void improve_exactly(TrialDesign& best) const {
    if (equations_.primary_rows == 0)
      return evaluator_.keep_better(best, evaluator_.evaluate(minimise_within_limits(context_, *objective_, best.u)));
    const NonlinearSystem equations = make_equations_near(context_, best.u, equations_);
    const auto restore = [&](const VectorX& u) { return solve_levenberg_marquardt(equations, u).u; };
    const VectorX u = optimise_exact_solutions(context_, *objective_, equations, restore, {best.u}).u;
    evaluator_.keep_better(best, evaluator_.evaluate(u));
  }

  /// Evaluates an exact or nearly exact design, both unchanged and with the masses solved for.
  void evaluate_candidate(TrialDesign& best, const VectorX& u) const {
    evaluator_.keep_better(best, evaluator_.evaluate(u));
    if (objective_ == nullptr && best.is_balanced) return;
    evaluator_.keep_better(best, evaluator_.solve_at_geometry(u));
    if (const auto special = snap_to_length_ratios(context_, u); special && !best.is_balanced)
      evaluator_.keep_better(best, evaluator_.solve_at_geometry(*special));
  }

  /// Gauss–Newton on all variables.
  std::vector<VectorX> find_exact_designs() {
    if (equations_.primary_rows == 0) return {anchor_};
    ExactSearchOptions options;
    options.starts.push_back(anchor_);
    for (const VectorX& u : prepare_starts()) options.starts.push_back(u);
    options.max_restarts = context_.problem.search.max_restarts;
    options.max_solutions = objective_ == nullptr ? 1 : max_exact_designs;
    options.is_usable = [this](const VectorX& u) {
      if (!context_.infeasibility_reason(u).empty()) return false;
      if (objective_ == nullptr || std::isfinite((*objective_)(u, nullptr))) return true;
      if (evaluator_.is_balanced(u)) balanced_without_value_ = u;
      return false;
    };
    ExactSolutions exact = find_exact_solutions(context_, equations_, options);
    best_descent_ = exact.closest;
    for (VectorX& u : exact.solutions)
      if (const VectorX better = solve_levenberg_marquardt(equations_, u).u; is_exact(context_, equations_, better))
        u = better;
    return exact.solutions;
  }

  /// Space-filling samples of the lengths, with the other variables that minimise the residual there. Returns the best
  /// of them.
  std::vector<VectorX> prepare_starts() {
    std::vector<std::pair<double, VectorX>> points;
    const int count = 8 + 8 * static_cast<int>(geometric_variables_.size());
    for (const VectorX& lengths :
         low_discrepancy_points(count, static_cast<int>(geometric_variables_.size()), context_.problem.search.seed)) {
      if (context_.budget.is_spent()) break;
      VectorX u = anchor_;
      u(geometric_variables_) = lengths;
      ++context_.budget.geometries;
      const numerics::LeastSquaresResult descent = solve_inertial_variables(u);
      if (descent.values.size() > 0 && context_.infeasibility_reason(descent.u).empty())
        points.emplace_back(descent.values.squaredNorm(), descent.u);
    }
    std::stable_sort(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<VectorX> starts;
    for (std::size_t k = 0; k < std::min<std::size_t>(points.size(), max_joint_starts); ++k)
      starts.push_back(points[k].second);
    samples_ = std::move(points);
    return starts;
  }

  /// Gauss–Newton on the variables that do not change the geometry, with the goal's rows at fixed samples.
  numerics::LeastSquaresResult solve_inertial_variables(const VectorX& u) const {
    return solve_for(equations_, inertial_variables_, u, 30);
  }

  /// For use if the joint search fails: solves for the other variables at the lengths of the best samples.
  TrialDesign solve_at_samples() {
    TrialDesign best;
    evaluator_.keep_better(best, evaluator_.solve_at_geometry(anchor_));
    for (std::size_t k = 0; k < std::min<std::size_t>(samples_.size(), max_joint_starts) && !best.is_balanced; ++k) {
      if (context_.budget.is_spent()) break;
      evaluator_.keep_better(best, evaluator_.solve_at_geometry(samples_[k].second));
    }
    return best;
  }

  /// Whether designs exist at neighbouring lengths, too.
  bool has_neighbouring_designs(const TrialDesign& trial) const {
    for (const double offset : {neighbour_offset, -neighbour_offset}) {
      VectorX u = trial.u;
      for (std::size_t k = 0; k < geometric_variables_.size(); ++k) {
        double& value = u[geometric_variables_[k]];
        value += value > 0.9 ? -neighbour_offset : value < -0.9 ? neighbour_offset : (k % 2 == 0 ? offset : -offset);
      }
      if (evaluator_.solve_at_geometry(u).is_balanced) return true;
    }
    return false;
  }

  /// Improves the lengths of an exact design.
  /// @param are_lengths_optimised whether the bilevel search has optimised the lengths already, which requires that it
  /// handles all limits
  TrialDesign improve_geometry(const TrialDesign& from, bool are_lengths_optimised) {
    TrialDesign best = from;
    const bool is_relaxation_tight = from.figure <= tight_figure_;
    const bool has_exact_limits =
        context_.limits->size() == 0 || context_.problem.model->capabilities().are_samples_complete;
    if (are_lengths_optimised && is_relaxation_tight && has_exact_limits) return best;
    if (!has_neighbouring_designs(from)) {
      improve_exactly(best);
      evaluator_.keep_better(best, evaluator_.solve_at_geometry(best.u));
    } else if (!are_lengths_optimised ||
               context_.limits->size() > 0) {  // the bilevel search evaluates peaks at few samples
      search_lengths(
          best, [](const TrialDesign& trial) { return trial.is_balanced; }, are_lengths_optimised);
    }
    return best;
  }

  /// Derivative-free search over the lengths, from the best design and from space-filling points.
  /// @param is_local from the best design only, with small steps
  void search_lengths(TrialDesign& best, const std::function<bool(const TrialDesign&)>& is_candidate,
                      bool is_local = false) {
    MultistartSettings settings;
    std::map<std::vector<double>, double> evaluated;
    settings.objective = [&](const VectorX& lengths) {
      const std::vector<double> key(lengths.begin(), lengths.end());
      if (const auto at_key = evaluated.find(key); at_key != evaluated.end()) return at_key->second;
      VectorX u = best.u;
      u(geometric_variables_) = lengths;
      const TrialDesign trial = evaluator_.solve_at_geometry(u);
      const double value = trial.is_feasible && is_candidate(trial) ? evaluator_.cost(trial) : no_value;
      if (std::isfinite(value)) evaluator_.keep_better(best, trial);
      evaluated[key] = value;
      return value;
    };
    settings.starts = {best.u(geometric_variables_)};
    const auto n = static_cast<int>(geometric_variables_.size());
    if (!is_local)
      for (const VectorX& lengths : low_discrepancy_points(4 + 4 * n, n, context_.problem.search.seed))
        settings.starts.push_back(lengths);
    const std::string& requested_method = context_.problem.search.local;
    settings.method = requested_method == "cobyla" || requested_method == "sbplx" || requested_method == "bobyqa"
                          ? requested_method
                          : "bobyqa";
    settings.max_local_searches = is_local ? 1 : 2;
    settings.max_evaluations = std::min(context_.problem.search.max_evaluations, is_local ? 8 + 8 * n : 40 + 40 * n);
    if (is_local) settings.initial_step = 0.01;
    settings.min_step = 1e-5;
    search_multistart(settings, context_.budget);
  }

  /// Without conditions, gradient descent applies to all variables at once.
  void search_all_variables(TrialDesign& best) const {
    if (objective_ == nullptr || !objective_->has_max_terms() || context_.budget.is_spent()) return;
    if (const auto end = minimise_max_terms_from(context_, *objective_, best.u))
      evaluator_.keep_better(best, evaluator_.evaluate(*end));
  }

  /// One start of search_without_conditions, unless there is a balanced design: the search for such may take all the
  /// time that is left.
  void prepare_compromise(TrialDesign& best) {
    if (best.is_balanced || is_compromise_prepared_ || !evaluator_.is_figure_first()) return;
    is_compromise_prepared_ = true;
    std::vector<double> ends;
    search_without_conditions(best, 1, ends);
  }

  /// Minimises the objective regardless of the conditions.
  /// @param ends receives the value at which each start ended
  /// @return whether the bilevel search applies to the problem
  bool search_without_conditions(TrialDesign& best, int max_starts, std::vector<double>& ends) {
    const auto handle_start_end = [&](const VectorX& u, bool) {
      TrialDesign end;
      if (u.size() > 0 && context_.is_admissible(u)) end = evaluator_.evaluate(u);
      evaluator_.keep_better(best, end);
      ends.push_back(end.is_feasible ? end.figure : no_value);
      return static_cast<int>(ends.size()) >= max_starts || compare_starts(ends, best.figure).is_reached();
    };
    const BilevelResult designs = search_bilevel(context_, anchor_, objective_, true, handle_start_end);
    for (const VectorX& u : designs.balanced) evaluator_.keep_better(best, evaluator_.solve_at_geometry(u));
    return designs.is_applicable;
  }

  /// The best design that is not balanced.
  TrialDesign search_compromise(TrialDesign best) {
    std::vector<double> ends;
    const bool is_bilevel_applicable =
        evaluator_.is_figure_first() && search_without_conditions(best, context_.problem.search.max_restarts, ends);
    if (is_bilevel_applicable && !best.is_balanced) context_.budget.ends = std::move(ends);
    evaluator_.keep_better(best, evaluator_.solve_at_geometry(anchor_));
    if (best_descent_.values.size() > 0) evaluator_.keep_better(best, evaluator_.evaluate(best_descent_.u));
    for (const VectorX& u : unbalanced_candidates_) evaluator_.keep_better(best, evaluator_.solve_at_geometry(u));
    if (best.is_feasible && !is_bilevel_applicable) search_lengths(best, [](const TrialDesign&) { return true; });
    return best;
  }

  GeometrySearchResult report(const TrialDesign& best) const {
    GeometrySearchResult design;
    design.is_found = best.is_feasible;
    design.is_balanced = best.is_balanced;
    design.minimises_residual = !best.is_balanced && !evaluator_.is_figure_first();
    design.u = best.is_feasible ? best.u : anchor_;
    if (!best.is_balanced) design.balanced_without_value = balanced_without_value_;
    return design;
  }

  const SolverContext& context_;
  VectorX anchor_;
  const NonlinearSystem& equations_;
  const ScaledObjective* objective_;
  TrialEvaluator evaluator_;
  bool is_compromise_prepared_ = false;
  std::vector<int> geometric_variables_, inertial_variables_;
  std::optional<VectorX> balanced_without_value_;
  /// Least figure of a design that is exact without any loss against its relaxation, hence optimal for its lengths.
  double tight_figure_ = std::numeric_limits<double>::infinity();
  numerics::LeastSquaresResult best_descent_;
  std::vector<VectorX> unbalanced_candidates_;
  std::vector<std::pair<double, VectorX>> samples_;
};

}  // namespace

GeometrySearchResult search_geometry(const SolverContext& context, const VectorX& anchor,
                                     const NonlinearSystem& equations, const ScaledObjective* objective) {
  return GeometrySearch(context, anchor, equations, objective).run();
}

TrialEvaluator::TrialEvaluator(const SolverContext& context, const NonlinearSystem& equations,
                               const ScaledObjective* objective)
    : context_(context),
      equations_(equations),
      objective_(objective),
      inertial_variables_(inertial_variables(context)) {}

double TrialEvaluator::cost(const TrialDesign& trial) const {
  if (trial.is_balanced) return objective_ != nullptr ? trial.figure : 0;
  return is_figure_first() ? trial.figure : trial.residual;
}

void TrialEvaluator::keep_better(TrialDesign& best, TrialDesign trial) const {
  if (!trial.is_feasible || !std::isfinite(cost(trial))) return;
  const bool better = !best.is_feasible || (trial.is_balanced && !best.is_balanced) ||
                      (trial.is_balanced == best.is_balanced && cost(trial) < cost(best));
  if (!better) return;
  context_.budget.incumbent.offer(trial.u, trial.is_balanced, cost(trial));
  best = std::move(trial);
}

TrialDesign TrialEvaluator::evaluate(const VectorX& u) const {
  TrialDesign trial;
  trial.u = u;
  trial.is_feasible = context_.is_physical(u) && context_.infeasibility_reason(u).empty();
  if (!trial.is_feasible) return trial;
  trial.is_balanced = is_balanced(u);
  evaluate_figures(trial);
  return trial;
}

bool TrialEvaluator::is_balanced(const VectorX& u) const {
  const Conditions conditions = context_.conditions_at(u);
  if (conditions.status != ConditionsStatus::done || !context_.is_admissible(u)) return false;
  if (conditions.parameter_rows() == 0) return true;
  const VectorX residual =
      scaled_residuals(conditions, conditions::term_values(context_.mechanism(u), context_.options.loose_springs))
          .head(conditions.parameter_rows());
  return numerics::max_abs(residual) < condition_tolerance;
}

void TrialEvaluator::evaluate_figures(TrialDesign& trial) const {
  if (objective_ != nullptr && !std::isfinite(trial.figure)) trial.figure = (*objective_)(trial.u, nullptr);
  VectorX values;
  trial.residual = equations_.primary_rows == 0                    ? 0
                   : equations_.evaluate(trial.u, values, nullptr) ? values.head(equations_.primary_rows).norm()
                                                                   : std::numeric_limits<double>::quiet_NaN();
}

TrialDesign TrialEvaluator::solve_at_geometry(const VectorX& u) const {
  TrialDesign trial;
  trial.u = u;
  if (!context_.infeasibility_reason(u).empty()) return trial;
  ++context_.budget.geometries;
  try {
    const VectorX x = context_.scaling.to_variables(u);
    const DesignProblem inner = make_fixed_geometry_problem(context_, x, context_.budget.remaining_time());
    const DesignOutcome outcome = solve_design(inner);
    if (outcome.status == DesignStatus::unsolved || outcome.status == DesignStatus::no_feasible_start) return trial;
    trial.is_balanced = is_success(outcome);
    for (std::size_t k = 0; k < inertial_variables_.size(); ++k) {
      const auto i = inertial_variables_[k];
      trial.u[i] = context_.scaling.to_unit(i, outcome.x[static_cast<Eigen::Index>(k)]);
    }
    trial.is_feasible = context_.is_admissible(trial.u);
    trial.figure = outcome.objective;
    evaluate_figures(trial);
  } catch (const SpecError&) {
    trial.is_feasible = false;  // an expression of the spec has no value here
  } catch (const std::invalid_argument&) {
    trial.is_feasible = false;
  } catch (const DeadlineExceeded&) {
    trial.is_feasible = false;
  }
  return trial;
}

}  // namespace balance::design
