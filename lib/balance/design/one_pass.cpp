#include "balance/design/one_pass.hpp"

#include "balance/design/findings.hpp"
#include "balance/design/freedom.hpp"
#include "balance/design/geometric.hpp"
#include "balance/design/optimum.hpp"
#include "balance/design/verdict.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

namespace {

using namespace designing;

/// Exact solutions from which the objective is improved, where one is not enough.
constexpr int starts_of_optimisation = 6, starts_of_simulation = 2, starts_of_inner = 2;

class Designer {
 public:
  using Exact = std::function<VectorX(const VectorX&)>;
  using Figure = std::function<double(const VectorX&)>;

  explicit Designer(const DesignProblem& problem)
      : budget_(problem.search.seconds, problem.watch), context_(problem, budget_) {
    if (problem.objective) merit_.emplace(context_, *problem.objective);
  }

  Pass run() {
    out_.x = context_.box.numbers(start_);
    if (context_.survey.any_geometric())
      design_geometry();
    else if (derive(start_) && !is_balanced_by_nature())
      design_masses();
    return {std::move(out_), convex_};
  }

 private:
  bool derive(const VectorX& u) {
    out_.conditions = context_.conditions_at(u);
    if (out_.conditions.status == ConditionsStatus::done) return true;
    out_.reason = out_.conditions.reason;
    return false;
  }

  /// No condition, with those of the start derived, and no objective: the start values are the design.
  bool is_balanced_by_nature() {
    const Conditions& all = out_.conditions;
    if (context_.problem.goals.empty() || merit_ || all.status != ConditionsStatus::done || all.rank > 0) return false;
    if (!context_.allows(start_) || !context_.fault(start_).empty()) return false;
    out_.method = DesignMethod::nothing_to_do;
    const FixedRows none(context_, out_.conditions);
    if (finish(start_)) finish_search(fixed_equations(context_, none, {}, VectorX(0)), start_, true);
    return true;
  }

  void design_masses() {
    const FixedRows rows(context_, out_.conditions);
    out_.occurring = find_occurring(context_, out_.conditions, start_);
    const VectorX at_start = rows.exact(start_);
    std::vector<int> changeable;
    for (int k = 0; k < rows.size(); ++k) {
      if (!out_.occurring[static_cast<std::size_t>(k)].empty())
        changeable.push_back(k);
      else if (!(std::abs(at_start[k]) < met))
        out_.unmet_fixed.push_back(k);
    }
    const bool affine = rows.affine(changeable);
    out_.method = changeable.empty() ? DesignMethod::nothing_to_do
                  : affine           ? DesignMethod::affine
                                     : DesignMethod::polynomial;
    const VectorX zero = VectorX::Zero(static_cast<Eigen::Index>(changeable.size()));
    const Equations equations = fixed_equations(context_, rows, changeable, zero);
    const auto exact = [&](const VectorX& u) { return VectorX(rows.exact(u)(changeable)); };
    const auto proved_impossible = [&] {
      if (!context_.problem.inner) out_.proof = find_proof(context_, out_.conditions, rows, at_start);
      return out_.proof.has_value();
    };
    const bool convex = affine && context_.convex();
    convex_ = convex && merit_ && merit_->convex();
    budget_.begin_search();
    const VectorX u = without_fault(search(equations, exact, convex, proved_impossible));
    budget_.finish_search();
    if (!finish(u)) return;
    const bool unmet = out_.status == DesignStatus::compromise || out_.status == DesignStatus::impossible;
    if (unmet && !out_.proof && !context_.problem.inner) {
      out_.proof = find_proof(context_, out_.conditions, rows, out_.after);
      conclude(out_);
    }
    out_.proved = out_.status == DesignStatus::impossible;
    finish_search(equations, u, true);
  }

  void design_geometry() {
    out_.method = DesignMethod::geometric;
    std::string reason;
    const auto anchor = find_anchor(context_, reason);
    if (!anchor) {
      if (derive(start_)) out_.status = DesignStatus::not_found;
      return void(out_.reason = reason);
    }
    derive(*anchor);
    if (*anchor == start_ && is_balanced_by_nature()) return;
    const FixedRows none(context_, out_.conditions);  // without a condition no geometry matters
    Equations equations = out_.conditions.rank > 0 ? geometric_equations(context_, *anchor)
                                                   : fixed_equations(context_, none, {}, VectorX(0));
    const Conditions at_start = *anchor == start_ ? out_.conditions : Conditions{};
    budget_.begin_search();
    GeometricDesign design = search_geometry(context_, *anchor, equations, merit_ ? &*merit_ : nullptr);
    budget_.finish_search();
    if (design.valueless) return give_up(*design.valueless, "for any numbers that were found to meet the conditions");
    if (!design.found && merit_ && !finite_value(*anchor)) return give_up(*anchor, "for any lengths that were tried");
    if (design.by_residual) note_compromise();
    aim_ = merit_ && !design.by_residual ? Aim::objective : design.balanced ? Aim::nothing : Aim::residual;
    equations = equations_near(context_, design.u, equations);
    const VectorX u = without_fault(tidy(equations, design.u));
    out_.conditions = context_.conditions_at(u);
    if (out_.conditions.status != ConditionsStatus::done) return finish_without_list(equations, u);
    if (!finish(u)) return;
    if (!at_start.pivots.empty() && at_start.pivots == out_.conditions.pivots)
      out_.before = scaled_residuals(at_start, parameters(start_));
    out_.occurring = find_occurring(context_, out_.conditions, u);
    for (const int k : out_.open)
      if (out_.occurring[static_cast<std::size_t>(k)].empty()) out_.unmet_fixed.push_back(k);
    conclude(out_);
    finish_search(equations, u, false);
  }

  void finish_without_list(const Equations& equations, const VectorX& u) {
    VectorX values;
    const bool solved = equations.evaluate(u, values, nullptr) && worst(equations, values) < met;
    out_.status = solved ? DesignStatus::balanced : DesignStatus::compromise;
    out_.x = context_.box.numbers(u);
    out_.reason = "the conditions of the final geometry cannot be listed: " + out_.conditions.reason;
    finish_search(equations, u, false);
  }

  /// Exact solutions, the best of them; or a compromise.
  VectorX search(const Equations& equations, const Exact& exact, bool convex,
                 const std::function<bool()>& proved_impossible) {
    if (context_.problem.goals.empty()) return tidy(equations, least_objective(start_));
    ExactSearch found = find_exact(context_, equations, effort(convex, proved_impossible));
    const auto back = [&](const VectorX& u) { return polished(equations, u, exact); };
    if (found.solutions.empty() && !found.unusable.empty()) {
      budget_.finish_search();  // it may have been the time that was missing
      if (finite_value(found.unusable.front())) {
        aim_ = Aim::objective;
        return tidy(equations, found.unusable.front());
      }
      give_up(found.unusable.front(), "for any numbers that were found to meet the conditions");
      return start_;
    }
    if (found.solutions.empty() || (merit_ && !context_.problem.objective->size && misses_own()))
      return tidy(equations, compromise(equations, found.best, convex));
    for (VectorX& u : found.solutions)
      if (const VectorX better = back(u); is_exact(context_, equations, better) && has_value(better)) u = better;
    LinearConditions linear;
    if (convex) {
      linear = linear_conditions(equations, context_.box.size());
      if (const auto nearest = nearest_exact(context_, linear)) {
        const VectorX u = back(*nearest);
        if (is_exact(context_, equations, u) && has_value(u)) found.solutions.front() = u;
      }
    }
    if (!merit_) return tidy(equations, found.solutions.front());
    aim_ = Aim::objective;
    return tidy(equations, take(best_of(equations, linear, back, found.solutions, convex)));
  }

  bool finite_value(const VectorX& u) const { return std::isfinite((*merit_)(u, nullptr)); }
  bool has_value(const VectorX& u) const { return !merit_ || finite_value(u); }

  /// No design: the objective has no value where it is asked for.
  void give_up(const VectorX& u, const std::string& where) {
    out_.status = DesignStatus::unsolved;
    out_.reason = without_value(*context_.problem.objective, where, merit_->trouble(u));
    given_up_ = true;
  }

  VectorX tidy(const Equations& equations, const VectorX& u) const {
    if (!merit_) return tidied(context_, equations, Figure(), u);
    return tidied(
        context_, equations, [this](const VectorX& v) { return (*merit_)(v, nullptr); }, u);
  }

  /// Some condition that parameters could meet is not, whatever the free numbers are.
  bool misses_own() const {
    return std::any_of(out_.unmet_fixed.begin(), out_.unmet_fixed.end(),
                       [&](int k) { return k < out_.conditions.own_rows(); });
  }

  Effort effort(bool convex, const std::function<bool()>& proved_impossible) const {
    const int restarts = context_.problem.search.restarts;
    Effort effort{
        restarts, context_.problem.inner ? starts_of_inner : starts_of_optimisation, proved_impossible, {}, {}};
    if (merit_) effort.usable = [this](const VectorX& u) { return finite_value(u); };
    if (!merit_ || (convex && merit_->convex()))
      effort.wanted = 1;
    else if (merit_->simulated())
      effort.wanted = starts_of_simulation;
    // a convex problem without a solution has none anywhere; the inequalities' tangents may mislead a descent
    if (convex && !merit_) effort.restarts = context_.inequalities() > 0 ? std::min(restarts, 5) : 0;
    return effort;
  }

  Optimum best_of(const Equations& equations, const LinearConditions& linear, const Exact& back,
                  const std::vector<VectorX>& solutions, bool convex) const {
    const bool proving = convex && merit_->convex();
    Optimum best;
    best.u = solutions.front();
    best.value = (*merit_)(best.u, nullptr);
    // the bound's own search does not need another one before it
    if (!proving || !context_.problem.inner) best = best_exact(context_, *merit_, equations, back, solutions);
    if (convex && linear.a.rows() == linear.a.cols()) {  // there is no other solution
      best.bound = best.value;
      best.global = true;
      return best;
    }
    return proving ? minimise_convex(context_, *merit_, linear, back, best.u) : best;
  }

  VectorX take(const Optimum& optimum) {
    if (std::isfinite(optimum.bound)) out_.lower_bound = optimum.bound;
    proved_best_ = optimum.global && std::isfinite(optimum.value);
    return optimum.u;
  }

  /// The numbers within their bounds for which the objective is least, whatever the conditions.
  VectorX least_objective(const VectorX& from) {
    aim_ = Aim::objective;
    const LinearConditions none{MatrixX(0, start_.size()), VectorX(0)};
    if (merit_->convex() && context_.convex() && context_.allows(from))
      return take(minimise_convex(
          context_, *merit_, none, [](const VectorX& u) { return u; }, from));
    return take(best_compromise(context_, *merit_, from));
  }

  void note_compromise() {
    out_.notes.push_back("a compromise: the numbers that leave the smallest sum of squared residuals");
  }

  VectorX compromise(const Equations& equations, const Descent& best, bool convex) {
    const SearchOptions& options = context_.problem.search;
    if (merit_ && !context_.problem.objective->size) {
      out_.notes.push_back("a compromise: the numbers within their bounds for which " +
                           context_.problem.objective->name + " is smallest, whatever the conditions");
      return least_objective(context_.allows(best.u) ? best.u : start_);
    }
    note_compromise();
    aim_ = Aim::residual;
    const bool slow = !context_.map.polynomial();
    const int evaluations = convex ? 0 : slow ? std::max(1, options.evaluations / 20) : options.evaluations;
    const VectorX u = least_residual(context_, equations, best, evaluations);
    return merit_ ? prefer_small(equations, u, convex) : u;
  }

  /// Among the numbers that leave the same residuals as u those with the least objective.
  VectorX prefer_small(const Equations& equations, const VectorX& u, bool convex) const {
    VectorX target;
    if (!equations.evaluate(u, target, nullptr) || !context_.allows(u)) return u;
    Equations shifted = equations;
    const VectorX left = target.head(equations.conditions);
    shifted.evaluate = [&equations, left](const VectorX& v, VectorX& values, MatrixX* jacobian) {
      if (!equations.evaluate(v, values, jacobian)) return false;
      values.head(left.size()) -= left;
      return true;
    };
    const auto back = [&](const VectorX& v) { return gauss_newton(shifted, v).u; };
    const LinearConditions linear = convex ? linear_conditions(shifted, context_.box.size()) : LinearConditions{};
    return best_of(shifted, linear, back, {u}, convex).u;
  }

  VectorX parameters(const VectorX& u) const {
    return term_values(context_.mechanism(u), context_.options.loose_springs);
  }

  /// The start values in place of numbers that make no mechanism.
  VectorX without_fault(const VectorX& u) const { return context_.fault(u).empty() ? u : start_; }

  /// @return false if there is no design, because there is no mechanism or the objective has no value
  bool finish(const VectorX& u) {
    if (given_up_) return false;
    if (const std::string fault = context_.fault(u); !fault.empty()) {
      out_.status = DesignStatus::unsolved;
      out_.reason = "no numbers were found that make a mechanism: " + fault;
      given_up_ = true;
      return false;
    }
    out_.x = context_.box.numbers(u);
    if (merit_) {
      out_.objective_start = (*merit_)(start_, nullptr);
      out_.objective = (*merit_)(u, nullptr);
      const double round_off = merit_->round_off();
      for (double* value : {&out_.objective_start, &out_.objective})
        if (std::abs(*value) <= round_off) *value = 0;
      if (!std::isfinite(out_.objective)) {
        give_up(u, "for any numbers that were tried");
        return false;
      }
    }
    out_.before = scaled_residuals(out_.conditions, parameters(start_));
    out_.after = scaled_residuals(out_.conditions, parameters(u));
    conclude(out_);
    return true;
  }

  /// What is claimed of the search, and what it leaves free.
  void finish_search(const Equations& equations, const VectorX& u, bool precise) {
    if (merit_ && aim_ == Aim::nothing) aim_ = Aim::objective;
    // exact, and nothing is below what no value is below
    const bool at_bound = merit_ && out_.objective <= merit_->lower_bound() && out_.status != DesignStatus::compromise;
    if (at_bound) out_.lower_bound = out_.objective;
    judge(context_, aim_, (proved_best_ || at_bound) && aim_ == Aim::objective, out_);
    if (context_.problem.inner || (out_.status != DesignStatus::balanced && out_.status != DesignStatus::not_asked))
      return;
    out_.freedom = find_freedom(context_, equations, merit_ ? &*merit_ : nullptr, u, precise);
  }

  Budget budget_;
  Context context_;
  std::optional<FigureOfMerit> merit_;
  VectorX start_ = context_.box.start();
  DesignOutcome out_;
  Aim aim_ = Aim::nothing;
  bool proved_best_ = false, given_up_ = false, convex_ = false;
};

}  // namespace

namespace designing {

Pass pass_once(const DesignProblem& problem) { return Designer(problem).run(); }

}  // namespace designing

}  // namespace balance
