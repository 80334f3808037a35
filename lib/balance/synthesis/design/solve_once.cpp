#include "balance/synthesis/design/solve_once.hpp"

#include "balance/foundation/numerics/extrema.hpp"
#include "balance/synthesis/design/derived_problems.hpp"
#include "balance/synthesis/design/geometry_search.hpp"
#include "balance/synthesis/design/optimum_search.hpp"
#include "balance/synthesis/design/solution_analysis.hpp"

#include <algorithm>
#include <cmath>

namespace balance::design {

using numerics::NonlinearSystem;

namespace {

/// Maximum numbers of exact solutions from which the objective is optimised, if several are needed.
constexpr int max_exact_starts = 6, max_simulated_starts = 2, max_subproblem_starts = 2;
/// Difference from a proved lower bound at which a design counts as optimal, relative to its value.
constexpr double bound_tolerance = 1e-7;
/// Distance from a bound, in unit coordinates, that is an error of a cone program, and the change of a figure, relative
/// to its value, that this may cause.
constexpr double vertex_tolerance = 1e-6, vertex_value_tolerance = 1e-9;

class SingleSolver {
 public:
  using Exact = std::function<VectorX(const VectorX&)>;
  using Figure = std::function<double(const VectorX&)>;

  explicit SingleSolver(const DesignProblem& problem)
      : budget_(problem.search.max_time, problem.on_progress), context_(problem, budget_) {
    if (problem.objective) objective_.emplace(context_, *problem.objective);
  }

  SingleSolve run() {
    outcome_.x = context_.scaling.to_variables(start_);
    if (context_.classification.has_geometric())
      solve_geometry();
    else if (derive_conditions(start_) && !is_inherently_balanced())
      solve_masses();
    return {std::move(outcome_), is_convex_};
  }

 private:
  bool derive_conditions(const VectorX& u) {
    outcome_.conditions = context_.conditions_at(u);
    if (outcome_.conditions.status == ConditionsStatus::done) return true;
    outcome_.reason = outcome_.conditions.reason;
    return false;
  }

  /// If there are no conditions at the start and no objective, the start values are the design.
  bool is_inherently_balanced() {
    const Conditions& conditions = outcome_.conditions;
    if (context_.problem.goals.empty() || objective_ || conditions.status != ConditionsStatus::done ||
        conditions.rank > 0)
      return false;
    if (!context_.is_admissible(start_) || !context_.invalidity_reason(start_).empty()) return false;
    outcome_.method = DesignMethod::none;
    if (finish(start_)) finish_search();
    return true;
  }

  /// An exact design at which the objective reaches its lower bound, so that nothing has to be searched: the numbers of
  /// the anchor, or all elements at zero. The conditions must be those of the anchor.
  std::optional<VectorX> find_known_optimum(const VectorX& anchor) const {
    if (!objective_ || !std::isfinite(objective_->lower_bound())) return std::nullopt;
    VectorX without_elements = anchor;
    for (int i = 0; i < context_.scaling.size(); ++i)
      if (const double half = context_.scaling.half_width()[i];
          half > 0 && !context_.classification.is_geometric[static_cast<std::size_t>(i)])
        without_elements[i] = std::clamp(-context_.scaling.centre()[i] / half, -1.0, 1.0);
    for (const VectorX& u : {anchor, without_elements}) {
      const double value = (*objective_)(u, nullptr);
      if (!(value <= objective_->lower_bound() + objective_->round_off())) continue;
      const VectorX residuals = scaled_residuals(outcome_.conditions, parameters(u));
      const bool is_balanced = residuals.size() == 0 || numerics::max_abs(residuals) < condition_tolerance;
      if (is_balanced && context_.is_admissible(u)) return u;
    }
    return std::nullopt;
  }

  void solve_masses() {
    const ConditionResidual rows(context_, outcome_.conditions);
    outcome_.condition_variables = find_condition_variables(context_, outcome_.conditions, start_);
    const VectorX at_start = rows.evaluate_from_mechanism(start_);
    std::vector<int> changeable;
    for (int k = 0; k < rows.size(); ++k) {
      if (!outcome_.condition_variables[static_cast<std::size_t>(k)].empty())
        changeable.push_back(k);
      else if (!(std::abs(at_start[k]) < condition_tolerance))
        outcome_.unmet_fixed_conditions.push_back(k);
    }
    const bool affine = rows.is_affine(changeable);
    outcome_.method = changeable.empty() ? DesignMethod::none
                      : affine           ? DesignMethod::affine
                                         : DesignMethod::polynomial;
    const VectorX zero = VectorX::Zero(static_cast<Eigen::Index>(changeable.size()));
    const NonlinearSystem equations = make_fixed_geometry_equations(context_, rows, changeable, zero);
    const auto exact = [&](const VectorX& u) { return VectorX(rows.evaluate_from_mechanism(u)(changeable)); };
    const auto proved_impossible = [&] {
      if (!context_.problem.is_subproblem)
        outcome_.certificate = find_infeasibility_certificate(context_, outcome_.conditions, rows, at_start);
      return outcome_.certificate.has_value();
    };
    const bool convex = affine && context_.is_convex();
    is_convex_ = convex && objective_ && objective_->is_convex();
    budget_.begin_search();
    const bool is_single = is_single_design(context_.problem);
    const std::optional<VectorX> known = is_single ? accept_only_design() : find_known_optimum(start_);
    if (known && !is_single) target_ = SearchTarget::objective;
    const VectorX u = known ? *known : replace_invalid_by_start(search(equations, exact, convex, proved_impossible));
    budget_.finish_search();
    if (!finish(u)) return;
    const bool unmet = outcome_.status == DesignStatus::compromise || outcome_.status == DesignStatus::infeasible;
    if (unmet && !outcome_.certificate && !context_.problem.is_subproblem) {
      outcome_.certificate =
          find_infeasibility_certificate(context_, outcome_.conditions, rows, outcome_.residuals_after);
      determine_status(outcome_);
    }
    outcome_.is_proved_infeasible = outcome_.status == DesignStatus::infeasible;
    finish_search();
  }

  void solve_geometry() {
    outcome_.method = DesignMethod::geometric;
    std::string reason;
    const auto anchor = find_feasible_start(context_, reason);
    if (!anchor) {
      if (derive_conditions(start_)) outcome_.status = DesignStatus::no_feasible_start;
      return void(outcome_.reason = reason);
    }
    derive_conditions(*anchor);
    if (*anchor == start_ && is_inherently_balanced()) return;
    const ConditionResidual none(context_, outcome_.conditions);  // without conditions, geometry is irrelevant
    NonlinearSystem equations = outcome_.conditions.rank > 0
                                    ? make_geometry_equations(context_, *anchor)
                                    : make_fixed_geometry_equations(context_, none, {}, VectorX(0));
    const Conditions at_start = *anchor == start_ ? outcome_.conditions : Conditions{};
    budget_.begin_search();
    GeometrySearchResult search_result;
    if (const std::optional<VectorX> known = find_known_optimum(*anchor)) {
      search_result.u = *known;
      search_result.is_found = search_result.is_balanced = true;
    } else {
      search_result = search_geometry(context_, *anchor, equations, objective_ ? &*objective_ : nullptr);
    }
    budget_.finish_search();
    keep_incumbent(search_result);
    if (search_result.balanced_without_value)
      return set_unsolved(*search_result.balanced_without_value,
                          "for any numbers that were found to meet the conditions");
    if (!search_result.is_found && objective_ && !finite_value(*anchor))
      return set_unsolved(*anchor, "for any lengths that were tried");
    if (search_result.minimises_residual) note_compromise();
    target_ = objective_ && !search_result.minimises_residual ? SearchTarget::objective
              : search_result.is_balanced                     ? SearchTarget::nothing
                                                              : SearchTarget::residual;
    equations = make_equations_near(context_, search_result.u, equations);
    const VectorX u = replace_invalid_by_start(snap(equations, search_result.u));
    outcome_.conditions = context_.conditions_at(u);
    if (outcome_.conditions.status != ConditionsStatus::done) return finish_without_conditions(equations, u);
    if (!finish(u)) return;
    if (!at_start.pivots.empty() && at_start.pivots == outcome_.conditions.pivots)
      outcome_.residuals_before = scaled_residuals(at_start, parameters(start_));
    outcome_.condition_variables = find_condition_variables(context_, outcome_.conditions, u);
    for (const int k : outcome_.unmet_conditions)
      if (outcome_.condition_variables[static_cast<std::size_t>(k)].empty())
        outcome_.unmet_fixed_conditions.push_back(k);
    determine_status(outcome_);
    finish_search();
  }

  /// The search may have been ended before it returned the best design that it evaluated.
  void keep_incumbent(GeometrySearchResult& result) const {
    const Incumbent& incumbent = budget_.incumbent;
    if (!incumbent.is_exact() || (result.is_balanced && !objective_)) return;
    if (result.is_balanced && !((*objective_)(result.u, nullptr) > incumbent.value())) return;
    result.u = incumbent.u();
    result.is_found = result.is_balanced = true;
    result.minimises_residual = false;
    result.balanced_without_value.reset();
  }

  void finish_without_conditions(const NonlinearSystem& equations, const VectorX& u) {
    VectorX values;
    const bool solved =
        equations.evaluate(u, values, nullptr) && max_condition_residual(equations, values) < condition_tolerance;
    outcome_.status = solved ? DesignStatus::balanced : DesignStatus::compromise;
    outcome_.x = context_.scaling.to_variables(u);
    outcome_.reason = "the conditions of the final geometry cannot be listed: " + outcome_.conditions.reason;
    finish_search();
  }

  VectorX accept_only_design() {
    target_ = objective_ ? SearchTarget::objective : SearchTarget::residual;
    is_proved_optimal_ = objective_.has_value();
    return start_;
  }

  /// The best exact solution, or a compromise.
  VectorX search(const NonlinearSystem& equations, const Exact& exact, bool convex,
                 const std::function<bool()>& proved_impossible) {
    if (context_.problem.goals.empty()) return snap(equations, minimise_objective(start_));
    if (const auto u = find_solution_at_bound(equations, exact)) return snap(equations, *u);
    ExactSolutions exact_solutions =
        find_exact_solutions(context_, equations, exact_search_options(convex, proved_impossible));
    const auto restore = [&](const VectorX& u) { return refine_solution(equations, u, exact); };
    if (exact_solutions.solutions.empty() && !exact_solutions.rejected.empty()) {
      budget_.finish_search();  // the objective may only have lacked time
      if (finite_value(exact_solutions.rejected.front())) {
        target_ = SearchTarget::objective;
        return snap(equations, exact_solutions.rejected.front());
      }
      set_unsolved(exact_solutions.rejected.front(), "for any numbers that were found to meet the conditions");
      return start_;
    }
    if (exact_solutions.solutions.empty() ||
        (objective_ && !context_.problem.objective->is_secondary && has_unmet_own_condition()))
      return snap(equations, find_compromise(equations, exact_solutions.closest, convex));
    for (VectorX& u : exact_solutions.solutions)
      if (const VectorX better = restore(u); is_exact(context_, equations, better) && has_value(better)) u = better;
    LinearConditions linear;
    if (convex) {
      linear = linear_conditions(equations, context_.scaling.size());
      if (const auto nearest = find_nearest_solution(context_, linear)) {
        const VectorX u = restore(*nearest);
        if (is_exact(context_, equations, u) && has_value(u)) exact_solutions.solutions.front() = u;
      }
    }
    if (!objective_) return snap(equations, exact_solutions.solutions.front());
    target_ = SearchTarget::objective;
    return snap(equations,
                record_optimum(optimise_solutions(equations, linear, restore, exact_solutions.solutions, convex)));
  }

  /// Moves numbers next to their bounds onto them and solves the conditions for the others: a cone program ends next to
  /// the bounds.
  static VectorX solve_on_bounds(const NonlinearSystem& equations, const VectorX& u) {
    std::vector<int> inner;
    VectorX all = u;
    for (Eigen::Index i = 0; i < u.size(); ++i)
      if (1 - std::abs(u[i]) < vertex_tolerance)
        all[i] = u[i] < 0 ? -1 : 1;
      else
        inner.push_back(static_cast<int>(i));
    if (inner.empty()) return all;
    all(inner) = solve_levenberg_marquardt(restrict_to_variables(equations, inner, all), u(inner)).u;
    return all;
  }

  /// The exact solution next to the start if it attains the proved lower bound of the problem.
  std::optional<VectorX> find_solution_at_bound(const NonlinearSystem& equations, const Exact& exact) {
    const double bound = context_.problem.proved_lower_bound;
    if (!objective_ || !std::isfinite(bound) || has_unmet_own_condition()) return std::nullopt;
    VectorX u = refine_solution(equations, start_, exact);
    if (!is_exact(context_, equations, u)) return std::nullopt;
    double value = (*objective_)(u, nullptr);
    const VectorX vertex = solve_on_bounds(equations, u);
    if (is_exact(context_, equations, vertex) && numerics::max_abs(exact(vertex)) < condition_tolerance)
      if (const double at_vertex = (*objective_)(vertex, nullptr);
          at_vertex <= value + vertex_value_tolerance * std::abs(value)) {
        u = vertex;
        value = at_vertex;
      }
    if (!(value - bound <= bound_tolerance * std::abs(value) + objective_->round_off())) return std::nullopt;
    target_ = SearchTarget::objective;
    outcome_.lower_bound = std::min(bound, value);
    is_proved_optimal_ = true;
    return u;
  }

  bool finite_value(const VectorX& u) const { return std::isfinite((*objective_)(u, nullptr)); }
  bool has_value(const VectorX& u) const { return !objective_ || finite_value(u); }

  /// Gives up: the objective has no value where it is needed.
  void set_unsolved(const VectorX& u, const std::string& where) {
    outcome_.status = DesignStatus::unsolved;
    outcome_.reason = undefined_objective_reason(*context_.problem.objective, where, objective_->failure_reason(u));
    has_given_up_ = true;
  }

  VectorX snap(const NonlinearSystem& equations, const VectorX& u) const {
    if (!objective_) return snap_to_special_values(context_, equations, Figure(), u);
    return snap_to_special_values(
        context_, equations, [this](const VectorX& v) { return (*objective_)(v, nullptr); }, u);
  }

  /// Whether a condition on parameters is unmet for all values of the free numbers.
  bool has_unmet_own_condition() const {
    return std::any_of(outcome_.unmet_fixed_conditions.begin(), outcome_.unmet_fixed_conditions.end(),
                       [&](int k) { return k < outcome_.conditions.parameter_rows(); });
  }

  ExactSearchOptions exact_search_options(bool convex, const std::function<bool()>& proved_impossible) const {
    const int restarts = context_.problem.search.max_restarts;
    ExactSearchOptions search_options{
        restarts, context_.problem.is_subproblem ? max_subproblem_starts : max_exact_starts, proved_impossible, {}, {}};
    if (objective_) search_options.is_usable = [this](const VectorX& u) { return finite_value(u); };
    if (!objective_ || (convex && objective_->is_convex()))
      search_options.max_solutions = 1;
    else if (objective_->is_simulated())
      search_options.max_solutions = max_simulated_starts;
    // A convex problem needs no restarts, except that linearised inequalities may mislead a descent.
    if (convex && !objective_)
      search_options.max_restarts = context_.inequality_count() > 0 ? std::min(restarts, 5) : 0;
    return search_options;
  }

  Optimum optimise_solutions(const NonlinearSystem& equations, const LinearConditions& linear, const Exact& restore,
                             const std::vector<VectorX>& solutions, bool convex) const {
    const bool proves_optimality = convex && objective_->is_convex();
    Optimum best;
    best.u = solutions.front();
    best.value = (*objective_)(best.u, nullptr);
    // In a subproblem, the convex optimisation below suffices.
    if (!proves_optimality || !context_.problem.is_subproblem)
      best = optimise_exact_solutions(context_, *objective_, equations, restore, solutions);
    if (convex && linear.matrix.rows() == linear.matrix.cols()) {  // the solution is unique
      best.lower_bound = best.value;
      best.is_global = true;
      return best;
    }
    return proves_optimality ? minimise_convex(context_, *objective_, linear, restore, best.u) : best;
  }

  VectorX record_optimum(const Optimum& optimum) {
    if (std::isfinite(optimum.lower_bound)) outcome_.lower_bound = optimum.lower_bound;
    is_proved_optimal_ = optimum.is_global && std::isfinite(optimum.value);
    return optimum.u;
  }

  /// Minimises the objective within the bounds, regardless of the conditions.
  VectorX minimise_objective(const VectorX& from) {
    target_ = SearchTarget::objective;
    const LinearConditions none{MatrixX(0, start_.size()), VectorX(0)};
    if (objective_->is_convex() && context_.is_convex() && context_.is_admissible(from))
      return record_optimum(minimise_convex(
          context_, *objective_, none, [](const VectorX& u) { return u; }, from));
    return record_optimum(optimise_compromise(context_, *objective_, from));
  }

  void note_compromise() {
    outcome_.notes.push_back("a compromise: the numbers that leave the smallest sum of squared residuals");
  }

  VectorX find_compromise(const NonlinearSystem& equations, const numerics::LeastSquaresResult& best, bool convex) {
    const study::SearchOptions& options = context_.problem.search;
    if (objective_ && !context_.problem.objective->is_secondary) {
      outcome_.notes.push_back("a compromise: the numbers within their bounds for which " +
                               context_.problem.objective->name + " is smallest, regardless of the conditions");
      // not from the end of the search for exact solutions, which depends on its time
      return minimise_objective(context_.is_admissible(best.u) && !context_.is_admissible(start_) ? best.u : start_);
    }
    note_compromise();
    target_ = SearchTarget::residual;
    const bool slow = !context_.features.polynomial();
    const int evaluations = convex ? 0 : slow ? std::max(1, options.max_evaluations / 20) : options.max_evaluations;
    const VectorX u = minimise_residual(context_, equations, best, evaluations);
    return objective_ ? minimise_at_fixed_residual(equations, u, convex) : u;
  }

  /// Minimises the objective among the designs with the same residuals as u.
  VectorX minimise_at_fixed_residual(const NonlinearSystem& equations, const VectorX& u, bool convex) const {
    VectorX target;
    if (!equations.evaluate(u, target, nullptr) || !context_.is_admissible(u)) return u;
    NonlinearSystem shifted = equations;
    const VectorX residual = target.head(equations.primary_rows);
    shifted.evaluate = [&equations, residual](const VectorX& v, VectorX& values, MatrixX* jacobian) {
      if (!equations.evaluate(v, values, jacobian)) return false;
      values.head(residual.size()) -= residual;
      return true;
    };
    const auto restore = [&](const VectorX& v) { return solve_levenberg_marquardt(shifted, v).u; };
    const LinearConditions linear = convex ? linear_conditions(shifted, context_.scaling.size()) : LinearConditions{};
    return optimise_solutions(shifted, linear, restore, {u}, convex).u;
  }

  VectorX parameters(const VectorX& u) const {
    return conditions::term_values(context_.mechanism(u), context_.options.loose_springs);
  }

  /// Replaces an invalid design by the start values.
  VectorX replace_invalid_by_start(const VectorX& u) const {
    return context_.invalidity_reason(u).empty() ? u : start_;
  }

  /// @return false if there is no design, because the mechanism is invalid or the objective has no value
  bool finish(const VectorX& u) {
    if (has_given_up_) return false;
    if (const std::string issue = context_.invalidity_reason(u); !issue.empty()) {
      outcome_.status = DesignStatus::unsolved;
      outcome_.reason = "no numbers were found that give a valid mechanism: " + issue;
      has_given_up_ = true;
      return false;
    }
    outcome_.x = context_.scaling.to_variables(u);
    if (objective_) {
      outcome_.start_objective = (*objective_)(start_, nullptr);
      outcome_.objective = (*objective_)(u, nullptr);
      const double round_off = objective_->round_off();
      for (double* value : {&outcome_.start_objective, &outcome_.objective})
        if (std::abs(*value) <= round_off) *value = 0;
      if (!std::isfinite(outcome_.objective)) {
        set_unsolved(u, "for any numbers that were tried");
        return false;
      }
    }
    outcome_.residuals_before = scaled_residuals(outcome_.conditions, parameters(start_));
    outcome_.residuals_after = scaled_residuals(outcome_.conditions, parameters(u));
    determine_status(outcome_);
    return true;
  }

  /// Records the optimality of the result.
  void finish_search() {
    if (objective_ && target_ == SearchTarget::nothing) target_ = SearchTarget::objective;
    // Global optimum: exact, and the objective reaches its lower bound.
    const bool at_bound =
        objective_ && outcome_.objective <= objective_->lower_bound() && outcome_.status != DesignStatus::compromise;
    if (at_bound) outcome_.lower_bound = outcome_.objective;
    assess_optimality(context_, target_, (is_proved_optimal_ || at_bound) && target_ == SearchTarget::objective,
                      outcome_);
  }

  SearchBudget budget_;
  SolverContext context_;
  std::optional<ScaledObjective> objective_;
  VectorX start_ = context_.scaling.start();
  DesignOutcome outcome_;
  SearchTarget target_ = SearchTarget::nothing;
  bool is_proved_optimal_ = false, has_given_up_ = false, is_convex_ = false;
};

}  // namespace

SingleSolve solve_once(const DesignProblem& problem) { return SingleSolver(problem).run(); }

}  // namespace balance::design
