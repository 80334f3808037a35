#include "balance/synthesis/design/solve_once.hpp"

#include "balance/synthesis/design/geometry_search.hpp"
#include "balance/synthesis/design/optimum_search.hpp"
#include "balance/synthesis/design/solution_analysis.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

namespace {

using namespace design;

/// Exact solutions from which the objective is improved, where one is not enough.
constexpr int max_exact_starts = 6, max_simulated_starts = 2, max_subproblem_starts = 2;

class SingleSolver {
 public:
  using Exact = std::function<VectorX(const VectorX&)>;
  using Figure = std::function<double(const VectorX&)>;

  explicit SingleSolver(const DesignProblem& problem)
      : budget_(problem.search.max_time, problem.on_progress), context_(problem, budget_) {
    if (problem.objective) objective_.emplace(context_, *problem.objective);
  }

  SingleSolve run() {
    out_.x = context_.scaling.to_variables(start_);
    if (context_.classification.has_geometric())
      solve_geometry();
    else if (derive_conditions(start_) && !is_inherently_balanced())
      solve_masses();
    return {std::move(out_), convex_};
  }

 private:
  bool derive_conditions(const VectorX& u) {
    out_.conditions = context_.conditions_at(u);
    if (out_.conditions.status == ConditionsStatus::done) return true;
    out_.reason = out_.conditions.reason;
    return false;
  }

  /// No condition, with those of the start derived, and no objective: the start values are the design.
  bool is_inherently_balanced() {
    const Conditions& all = out_.conditions;
    if (context_.problem.goals.empty() || objective_ || all.status != ConditionsStatus::done || all.rank > 0)
      return false;
    if (!context_.is_admissible(start_) || !context_.invalidity_reason(start_).empty()) return false;
    out_.method = DesignMethod::none;
    const ConditionResidual none(context_, out_.conditions);
    if (finish(start_)) finish_search(make_fixed_geometry_equations(context_, none, {}, VectorX(0)), start_, true);
    return true;
  }

  void solve_masses() {
    const ConditionResidual rows(context_, out_.conditions);
    out_.condition_variables = find_condition_variables(context_, out_.conditions, start_);
    const VectorX at_start = rows.evaluate_from_mechanism(start_);
    std::vector<int> changeable;
    for (int k = 0; k < rows.size(); ++k) {
      if (!out_.condition_variables[static_cast<std::size_t>(k)].empty())
        changeable.push_back(k);
      else if (!(std::abs(at_start[k]) < condition_tolerance))
        out_.unmet_fixed_conditions.push_back(k);
    }
    const bool affine = rows.is_affine(changeable);
    out_.method = changeable.empty() ? DesignMethod::none : affine ? DesignMethod::affine : DesignMethod::polynomial;
    const VectorX zero = VectorX::Zero(static_cast<Eigen::Index>(changeable.size()));
    const NonlinearSystem equations = make_fixed_geometry_equations(context_, rows, changeable, zero);
    const auto exact = [&](const VectorX& u) { return VectorX(rows.evaluate_from_mechanism(u)(changeable)); };
    const auto proved_impossible = [&] {
      if (!context_.problem.is_subproblem)
        out_.certificate = find_infeasibility_certificate(context_, out_.conditions, rows, at_start);
      return out_.certificate.has_value();
    };
    const bool convex = affine && context_.is_convex();
    convex_ = convex && objective_ && objective_->is_convex();
    budget_.begin_search();
    const VectorX u = replace_invalid_by_start(search(equations, exact, convex, proved_impossible));
    budget_.finish_search();
    if (!finish(u)) return;
    const bool unmet = out_.status == DesignStatus::compromise || out_.status == DesignStatus::infeasible;
    if (unmet && !out_.certificate && !context_.problem.is_subproblem) {
      out_.certificate = find_infeasibility_certificate(context_, out_.conditions, rows, out_.residuals_after);
      determine_status(out_);
    }
    out_.is_proved_infeasible = out_.status == DesignStatus::infeasible;
    finish_search(equations, u, true);
  }

  void solve_geometry() {
    out_.method = DesignMethod::geometric;
    std::string reason;
    const auto anchor = find_feasible_start(context_, reason);
    if (!anchor) {
      if (derive_conditions(start_)) out_.status = DesignStatus::no_feasible_start;
      return void(out_.reason = reason);
    }
    derive_conditions(*anchor);
    if (*anchor == start_ && is_inherently_balanced()) return;
    const ConditionResidual none(context_, out_.conditions);  // without a condition no geometry matters
    NonlinearSystem equations = out_.conditions.rank > 0
                                    ? make_geometry_equations(context_, *anchor)
                                    : make_fixed_geometry_equations(context_, none, {}, VectorX(0));
    const Conditions at_start = *anchor == start_ ? out_.conditions : Conditions{};
    budget_.begin_search();
    GeometrySearchResult design = search_geometry(context_, *anchor, equations, objective_ ? &*objective_ : nullptr);
    budget_.finish_search();
    if (design.balanced_without_value)
      return set_unsolved(*design.balanced_without_value, "for any numbers that were found to meet the conditions");
    if (!design.is_found && objective_ && !finite_value(*anchor))
      return set_unsolved(*anchor, "for any lengths that were tried");
    if (design.minimises_residual) note_compromise();
    aim_ = objective_ && !design.minimises_residual ? SearchTarget::objective
           : design.is_balanced                     ? SearchTarget::nothing
                                                    : SearchTarget::residual;
    equations = make_equations_near(context_, design.u, equations);
    const VectorX u = replace_invalid_by_start(snap(equations, design.u));
    out_.conditions = context_.conditions_at(u);
    if (out_.conditions.status != ConditionsStatus::done) return finish_without_conditions(equations, u);
    if (!finish(u)) return;
    if (!at_start.pivots.empty() && at_start.pivots == out_.conditions.pivots)
      out_.residuals_before = scaled_residuals(at_start, parameters(start_));
    out_.condition_variables = find_condition_variables(context_, out_.conditions, u);
    for (const int k : out_.unmet_conditions)
      if (out_.condition_variables[static_cast<std::size_t>(k)].empty()) out_.unmet_fixed_conditions.push_back(k);
    determine_status(out_);
    finish_search(equations, u, false);
  }

  void finish_without_conditions(const NonlinearSystem& equations, const VectorX& u) {
    VectorX values;
    const bool solved =
        equations.evaluate(u, values, nullptr) && max_condition_residual(equations, values) < condition_tolerance;
    out_.status = solved ? DesignStatus::balanced : DesignStatus::compromise;
    out_.x = context_.scaling.to_variables(u);
    out_.reason = "the conditions of the final geometry cannot be listed: " + out_.conditions.reason;
    finish_search(equations, u, false);
  }

  /// Exact solutions, the best of them; or a compromise.
  VectorX search(const NonlinearSystem& equations, const Exact& exact, bool convex,
                 const std::function<bool()>& proved_impossible) {
    if (context_.problem.goals.empty()) return snap(equations, minimise_objective(start_));
    ExactSolutions found = find_exact_solutions(context_, equations, exact_search_options(convex, proved_impossible));
    const auto back = [&](const VectorX& u) { return refine_solution(equations, u, exact); };
    if (found.solutions.empty() && !found.rejected.empty()) {
      budget_.finish_search();  // it may have been the time that was missing
      if (finite_value(found.rejected.front())) {
        aim_ = SearchTarget::objective;
        return snap(equations, found.rejected.front());
      }
      set_unsolved(found.rejected.front(), "for any numbers that were found to meet the conditions");
      return start_;
    }
    if (found.solutions.empty() ||
        (objective_ && !context_.problem.objective->is_secondary && has_unmet_own_condition()))
      return snap(equations, find_compromise(equations, found.closest, convex));
    for (VectorX& u : found.solutions)
      if (const VectorX better = back(u); is_exact(context_, equations, better) && has_value(better)) u = better;
    LinearConditions linear;
    if (convex) {
      linear = linear_conditions(equations, context_.scaling.size());
      if (const auto nearest = find_nearest_solution(context_, linear)) {
        const VectorX u = back(*nearest);
        if (is_exact(context_, equations, u) && has_value(u)) found.solutions.front() = u;
      }
    }
    if (!objective_) return snap(equations, found.solutions.front());
    aim_ = SearchTarget::objective;
    return snap(equations, record_optimum(optimise_solutions(equations, linear, back, found.solutions, convex)));
  }

  bool finite_value(const VectorX& u) const { return std::isfinite((*objective_)(u, nullptr)); }
  bool has_value(const VectorX& u) const { return !objective_ || finite_value(u); }

  /// No design: the objective has no value where it is asked for.
  void set_unsolved(const VectorX& u, const std::string& where) {
    out_.status = DesignStatus::unsolved;
    out_.reason = undefined_objective_reason(*context_.problem.objective, where, objective_->failure_reason(u));
    given_up_ = true;
  }

  VectorX snap(const NonlinearSystem& equations, const VectorX& u) const {
    if (!objective_) return snap_to_special_values(context_, equations, Figure(), u);
    return snap_to_special_values(
        context_, equations, [this](const VectorX& v) { return (*objective_)(v, nullptr); }, u);
  }

  /// Some condition that parameters could meet is not, whatever the free numbers are.
  bool has_unmet_own_condition() const {
    return std::any_of(out_.unmet_fixed_conditions.begin(), out_.unmet_fixed_conditions.end(),
                       [&](int k) { return k < out_.conditions.parameter_rows(); });
  }

  ExactSearchOptions exact_search_options(bool convex, const std::function<bool()>& proved_impossible) const {
    const int restarts = context_.problem.search.max_restarts;
    ExactSearchOptions effort{
        restarts, context_.problem.is_subproblem ? max_subproblem_starts : max_exact_starts, proved_impossible, {}, {}};
    if (objective_) effort.is_usable = [this](const VectorX& u) { return finite_value(u); };
    if (!objective_ || (convex && objective_->is_convex()))
      effort.max_solutions = 1;
    else if (objective_->is_simulated())
      effort.max_solutions = max_simulated_starts;
    // a convex problem without a solution has none anywhere; the inequalities' tangents may mislead a descent
    if (convex && !objective_) effort.max_restarts = context_.inequality_count() > 0 ? std::min(restarts, 5) : 0;
    return effort;
  }

  Optimum optimise_solutions(const NonlinearSystem& equations, const LinearConditions& linear, const Exact& back,
                             const std::vector<VectorX>& solutions, bool convex) const {
    const bool proving = convex && objective_->is_convex();
    Optimum best;
    best.u = solutions.front();
    best.value = (*objective_)(best.u, nullptr);
    // the bound's own search does not need another one before it
    if (!proving || !context_.problem.is_subproblem)
      best = optimise_exact_solutions(context_, *objective_, equations, back, solutions);
    if (convex && linear.a.rows() == linear.a.cols()) {  // there is no other solution
      best.lower_bound = best.value;
      best.is_global = true;
      return best;
    }
    return proving ? minimise_convex(context_, *objective_, linear, back, best.u) : best;
  }

  VectorX record_optimum(const Optimum& optimum) {
    if (std::isfinite(optimum.lower_bound)) out_.lower_bound = optimum.lower_bound;
    proved_best_ = optimum.is_global && std::isfinite(optimum.value);
    return optimum.u;
  }

  /// The numbers within their bounds for which the objective is least, whatever the conditions.
  VectorX minimise_objective(const VectorX& from) {
    aim_ = SearchTarget::objective;
    const LinearConditions none{MatrixX(0, start_.size()), VectorX(0)};
    if (objective_->is_convex() && context_.is_convex() && context_.is_admissible(from))
      return record_optimum(minimise_convex(
          context_, *objective_, none, [](const VectorX& u) { return u; }, from));
    return record_optimum(optimise_compromise(context_, *objective_, from));
  }

  void note_compromise() {
    out_.notes.push_back("a compromise: the numbers that leave the smallest sum of squared residuals");
  }

  VectorX find_compromise(const NonlinearSystem& equations, const LeastSquaresResult& best, bool convex) {
    const SearchOptions& options = context_.problem.search;
    if (objective_ && !context_.problem.objective->is_secondary) {
      out_.notes.push_back("a compromise: the numbers within their bounds for which " +
                           context_.problem.objective->name + " is smallest, whatever the conditions");
      return minimise_objective(context_.is_admissible(best.u) ? best.u : start_);
    }
    note_compromise();
    aim_ = SearchTarget::residual;
    const bool slow = !context_.features.polynomial();
    const int evaluations = convex ? 0 : slow ? std::max(1, options.max_evaluations / 20) : options.max_evaluations;
    const VectorX u = minimise_residual(context_, equations, best, evaluations);
    return objective_ ? minimise_at_fixed_residual(equations, u, convex) : u;
  }

  /// Among the numbers that leave the same residuals as u those with the least objective.
  VectorX minimise_at_fixed_residual(const NonlinearSystem& equations, const VectorX& u, bool convex) const {
    VectorX target;
    if (!equations.evaluate(u, target, nullptr) || !context_.is_admissible(u)) return u;
    NonlinearSystem shifted = equations;
    const VectorX left = target.head(equations.primary_rows);
    shifted.evaluate = [&equations, left](const VectorX& v, VectorX& values, MatrixX* jacobian) {
      if (!equations.evaluate(v, values, jacobian)) return false;
      values.head(left.size()) -= left;
      return true;
    };
    const auto back = [&](const VectorX& v) { return solve_levenberg_marquardt(shifted, v).u; };
    const LinearConditions linear = convex ? linear_conditions(shifted, context_.scaling.size()) : LinearConditions{};
    return optimise_solutions(shifted, linear, back, {u}, convex).u;
  }

  VectorX parameters(const VectorX& u) const {
    return term_values(context_.mechanism(u), context_.options.loose_springs);
  }

  /// The start values in place of numbers that make no mechanism.
  VectorX replace_invalid_by_start(const VectorX& u) const {
    return context_.invalidity_reason(u).empty() ? u : start_;
  }

  /// @return false if there is no design, because there is no mechanism or the objective has no value
  bool finish(const VectorX& u) {
    if (given_up_) return false;
    if (const std::string fault = context_.invalidity_reason(u); !fault.empty()) {
      out_.status = DesignStatus::unsolved;
      out_.reason = "no numbers were found that make a mechanism: " + fault;
      given_up_ = true;
      return false;
    }
    out_.x = context_.scaling.to_variables(u);
    if (objective_) {
      out_.start_objective = (*objective_)(start_, nullptr);
      out_.objective = (*objective_)(u, nullptr);
      const double round_off = objective_->round_off();
      for (double* value : {&out_.start_objective, &out_.objective})
        if (std::abs(*value) <= round_off) *value = 0;
      if (!std::isfinite(out_.objective)) {
        set_unsolved(u, "for any numbers that were tried");
        return false;
      }
    }
    out_.residuals_before = scaled_residuals(out_.conditions, parameters(start_));
    out_.residuals_after = scaled_residuals(out_.conditions, parameters(u));
    determine_status(out_);
    return true;
  }

  /// What is claimed of the search, and what it leaves free.
  void finish_search(const NonlinearSystem& equations, const VectorX& u, bool precise) {
    if (objective_ && aim_ == SearchTarget::nothing) aim_ = SearchTarget::objective;
    // exact, and nothing is below what no value is below
    const bool at_bound =
        objective_ && out_.objective <= objective_->lower_bound() && out_.status != DesignStatus::compromise;
    if (at_bound) out_.lower_bound = out_.objective;
    assess_optimality(context_, aim_, (proved_best_ || at_bound) && aim_ == SearchTarget::objective, out_);
    if (context_.problem.is_subproblem ||
        (out_.status != DesignStatus::balanced && out_.status != DesignStatus::no_goal))
      return;
    out_.solution_set = analyse_solution_set(context_, equations, objective_ ? &*objective_ : nullptr, u, precise);
  }

  SearchBudget budget_;
  SolverContext context_;
  std::optional<ScaledObjective> objective_;
  VectorX start_ = context_.scaling.start();
  DesignOutcome out_;
  SearchTarget aim_ = SearchTarget::nothing;
  bool proved_best_ = false, given_up_ = false, convex_ = false;
};

}  // namespace

namespace design {

SingleSolve solve_once(const DesignProblem& problem) { return SingleSolver(problem).run(); }

}  // namespace design

}  // namespace balance
