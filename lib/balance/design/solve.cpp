#include "balance/design/solve.hpp"

#include "balance/design/findings.hpp"
#include "balance/design/nlopt_search.hpp"
#include "balance/design/optimum.hpp"

#include <cmath>
#include <stdexcept>

namespace balance {

namespace {

using namespace designing;

/// Exact solutions from which the objective is improved, where one is not enough.
constexpr int starts_of_optimisation = 6, starts_of_simulation = 2;

class Designer {
 public:
  using Exact = std::function<VectorX(const VectorX&)>;
  using Figure = std::function<double(const VectorX&)>;

  explicit Designer(const DesignProblem& problem) : context_(problem), deadline_(problem.search.seconds) {
    if (problem.objective) merit_.emplace(context_);
    start_ = context_.box.start();
  }

  DesignOutcome run() {
    out_.x = context_.box.numbers(start_);
    out_.conditions = context_.derive(context_.mechanism(start_));
    if (out_.conditions.status != ConditionsStatus::done) {
      out_.reason = out_.conditions.reason;
      return std::move(out_);
    }
    if (context_.survey.any_geometric())
      design_geometry();
    else
      design_masses();
    return std::move(out_);
  }

 private:
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
    const auto hopeless = [&] {
      out_.proof = find_proof(context_, out_.conditions, rows, at_start);
      return out_.proof.has_value();
    };
    const VectorX u = search(equations, exact, affine && context_.physical.convex(), hopeless);
    finish(u);
    if (out_.status != DesignStatus::balanced && !out_.proof) {
      out_.proof = find_proof(context_, out_.conditions, rows, out_.after);
      conclude(out_);
    }
  }

  void design_geometry() {
    out_.method = DesignMethod::geometric;
    const Conditions at_start = out_.conditions;
    const FixedRows none(context_, at_start);  // without a condition no geometry matters
    const Equations equations = at_start.rank > 0 ? geometric_equations(context_, context_.mechanism(start_))
                                                  : fixed_equations(context_, none, {}, VectorX(0));
    const VectorX u = search(equations, {}, false, {});
    out_.conditions = context_.derive(context_.mechanism(u));
    if (out_.conditions.status != ConditionsStatus::done) {
      VectorX values;
      const bool solved = equations.evaluate(u, values, nullptr) && worst(equations, values) < met;
      out_.status = solved ? DesignStatus::balanced : DesignStatus::compromise;
      out_.x = context_.box.numbers(u);
      out_.reason = "the conditions of the final geometry cannot be listed: " + out_.conditions.reason;
      return;
    }
    finish(u);
    if (at_start.pivots == out_.conditions.pivots) out_.before = scaled_residuals(at_start, parameters(start_));
    out_.occurring = find_occurring(context_, out_.conditions, u);
    for (const int k : out_.open)
      if (out_.occurring[static_cast<std::size_t>(k)].empty()) out_.unmet_fixed.push_back(k);
    conclude(out_);
  }

  /// Exact solutions, the best of them; or a compromise.
  VectorX search(const Equations& equations, const Exact& exact, bool convex, const std::function<bool()>& hopeless) {
    ExactSearch found = find_exact(context_, equations, effort(convex, hopeless));
    const auto back = [&](const VectorX& u) { return polished(equations, u, exact); };
    const auto tidy = [&](const VectorX& u) {
      return tidied(context_, equations, merit_ ? [this](const VectorX& v) { return (*merit_)(v, nullptr); } : Figure(),
                    u);
    };
    if (found.solutions.empty() || (merit_ && !context_.problem.objective->size && !out_.unmet_fixed.empty()))
      return tidy(compromise(equations, found.best, convex));
    for (VectorX& u : found.solutions)
      if (const VectorX better = back(u); is_exact(context_, equations, better)) u = better;
    LinearConditions linear;
    if (convex) {
      linear = linear_conditions(equations, context_.box.size());
      if (const auto nearest = nearest_exact(context_, linear)) {
        const VectorX u = back(*nearest);
        if (is_exact(context_, equations, u)) found.solutions.front() = u;
      }
    }
    if (!merit_) return tidy(found.solutions.front());
    return tidy(take(best_of(equations, linear, back, found.solutions, convex)));
  }

  Effort effort(bool convex, const std::function<bool()>& hopeless) const {
    const int restarts = context_.problem.search.restarts;
    Effort effort{restarts, starts_of_optimisation, hopeless};
    if (!merit_ || (convex && merit_->convex()))
      effort.wanted = 1;
    else if (merit_->simulated())
      effort.wanted = starts_of_simulation;
    // a convex problem without a solution has none anywhere; the inequalities' tangents may mislead a descent
    if (convex && !merit_) effort.restarts = context_.physical.size() > 0 ? std::min(restarts, 5) : 0;
    return effort;
  }

  Optimum best_of(const Equations& equations, const LinearConditions& linear, const Exact& back,
                  const std::vector<VectorX>& solutions, bool convex) const {
    Optimum best = best_exact(context_, *merit_, equations, back, solutions, deadline_);
    if (convex && linear.a.rows() == linear.a.cols()) {  // there is no other solution
      best.bound = best.value;
      best.global = true;
      return best;
    }
    return convex && merit_->convex() ? minimise_convex(context_, *merit_, linear, back, best.u) : best;
  }

  VectorX take(const Optimum& optimum) {
    if (std::isfinite(optimum.bound)) out_.lower_bound = optimum.bound;
    out_.global = optimum.global;
    return optimum.u;
  }

  VectorX compromise(const Equations& equations, const Descent& best, bool convex) {
    const SearchOptions& options = context_.problem.search;
    if (merit_ && !context_.problem.objective->size) {
      out_.notes.push_back("a compromise: the numbers within their bounds for which " +
                           context_.problem.objective->name + " is smallest, whatever the conditions");
      const VectorX from = context_.is_physical(best.u) ? best.u : start_;
      const LinearConditions none{MatrixX(0, start_.size()), VectorX(0)};
      if (merit_->convex() && context_.physical.convex() && context_.is_physical(from))
        return take(minimise_convex(
            context_, *merit_, none, [](const VectorX& u) { return u; }, from));
      return take(best_compromise(context_, *merit_, from, deadline_));
    }
    out_.notes.push_back("a compromise: the numbers that leave the smallest sum of squared residuals");
    const bool slow = context_.survey.any_geometric() || !context_.map.polynomial();
    const int evaluations = convex ? 0 : slow ? std::max(1, options.evaluations / 10) : options.evaluations;
    const VectorX u = least_residual(context_, equations, best, evaluations);
    return merit_ ? prefer_small(equations, u, convex) : u;
  }

  /// Among the numbers that leave the same residuals as u those with the least objective.
  VectorX prefer_small(const Equations& equations, const VectorX& u, bool convex) const {
    VectorX target;
    if (!equations.evaluate(u, target, nullptr) || !context_.is_physical(u)) return u;
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
    return parameter_values(context_.mechanism(u), context_.options.loose_springs);
  }

  void finish(const VectorX& u) {
    out_.x = context_.box.numbers(u);
    out_.before = scaled_residuals(out_.conditions, parameters(start_));
    out_.after = scaled_residuals(out_.conditions, parameters(u));
    if (merit_) {
      out_.objective_start = (*merit_)(start_, nullptr);
      out_.objective = (*merit_)(u, nullptr);
    }
    conclude(out_);
  }

  Context context_;
  Deadline deadline_;
  std::optional<FigureOfMerit> merit_;
  VectorX start_;
  DesignOutcome out_;
};

}  // namespace

void SearchOptions::validate() const {
  const auto require = [](bool holds, const char* what) {
    if (!holds) throw std::invalid_argument(what);
  };
  require(is_global_method(global), "the global search is one of direct, crs, isres, esch, mlsl");
  require(is_local_method(local), "the local search is one of auto, slsqp, auglag, cobyla, bobyqa, sbplx");
  require(restarts >= 1 && restarts <= 10000, "the number of restarts lies between 1 and 10000");
  require(evaluations >= 1 && evaluations <= 100000000, "the number of evaluations lies between 1 and 1e8");
  require(seconds > 0 && std::isfinite(seconds), "the search's time must be positive");
}

DesignOutcome solve(const DesignProblem& problem) {
  problem.search.validate();
  return Designer(problem).run();
}

}  // namespace balance
