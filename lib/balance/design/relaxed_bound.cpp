#include "balance/design/relaxed_bound.hpp"

#include "balance/design/discrete_search.hpp"

#include <algorithm>
#include <cmath>

namespace balance::design {

namespace {

bool is_bound_useful(const DesignProblem& problem, const DesignOutcome& outcome) {
  if (problem.is_subproblem || problem.is_modular || !outcome.within_limits) return false;
  const bool without_goal = outcome.status == DesignStatus::no_goal;
  if (outcome.method != DesignMethod::polynomial && !without_goal) return false;
  if (outcome.status == DesignStatus::compromise) return true;
  return problem.objective && problem.all_convex_terms_at && outcome.optimality == Optimality::local_optimum &&
         (without_goal || outcome.status == DesignStatus::balanced);
}

void restart_from(const DesignProblem& problem, const VectorX& from, DesignOutcome& outcome,
                  const std::function<DesignOutcome(const DesignProblem&)>& again) {
  DesignProblem other = problem;
  for (std::size_t i = 0; i < other.variables.size(); ++i)
    other.variables[i].start =
        std::clamp(from[static_cast<Eigen::Index>(i)], other.variables[i].lower, other.variables[i].upper);
  DesignOutcome found = again(other);
  if (found.status != outcome.status || !(found.objective < outcome.objective)) return;
  found.residuals_before = outcome.residuals_before;
  found.start_objective = outcome.start_objective;
  outcome = std::move(found);
}

}  // namespace

void bound_by_relaxation(const DesignProblem& problem, DesignOutcome& outcome,
                         const std::function<DesignOutcome(const DesignProblem&)>& again) {
  if (!is_bound_useful(problem, outcome)) return;
  const BranchingRule all(problem, 0);
  const BranchNode root = all.root();
  NodeBounds bounds(problem);
  const NodeBounds::Bound bound = bounds(root, all.node_domain(root), BranchObjective::constrained_figure);
  if (!bound.has_relaxation) return;
  if (outcome.status == DesignStatus::compromise) {
    if (bound.is_feasible || !outcome.unmet_fixed_conditions.empty()) return;
    outcome.status = DesignStatus::infeasible;
    outcome.is_proved_infeasible = true;
    outcome.reason = "no masses and first moments within the bounds of the free numbers meet the conditions";
    return;
  }
  if (!std::isfinite(bound.lower_bound)) return;
  const auto close = [&] {
    return outcome.objective - bound.lower_bound <= relative_gap_tolerance * std::abs(outcome.objective);
  };
  if (!close() && bound.x.size() > 0) restart_from(problem, bound.x, outcome, again);
  outcome.lower_bound = std::min(bound.lower_bound, outcome.objective);
  if (!close()) return;
  outcome.optimality = Optimality::proved_global;
  outcome.effort.termination = SearchEffort::Termination::proved;
}

}  // namespace balance::design
