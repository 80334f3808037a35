#include "balance/design/relaxed_bound.hpp"

#include "balance/design/discrete_search.hpp"

#include <algorithm>
#include <cmath>

namespace balance::designing {

namespace {

bool is_open(const DesignProblem& problem, const DesignOutcome& outcome) {
  if (problem.inner || problem.modular || !outcome.within_limits) return false;
  const bool without_goal = outcome.status == DesignStatus::not_asked;
  if (outcome.method != DesignMethod::polynomial && !without_goal) return false;
  if (outcome.status == DesignStatus::compromise) return true;
  return problem.objective && problem.whole_figures_at && outcome.optimality == Optimality::local_best &&
         (without_goal || outcome.status == DesignStatus::balanced);
}

void improve(const DesignProblem& problem, const VectorX& from, DesignOutcome& outcome,
             const std::function<DesignOutcome(const DesignProblem&)>& again) {
  DesignProblem other = problem;
  for (std::size_t i = 0; i < other.variables.size(); ++i)
    other.variables[i].start =
        std::clamp(from[static_cast<Eigen::Index>(i)], other.variables[i].lower, other.variables[i].upper);
  DesignOutcome found = again(other);
  if (found.status != outcome.status || !(found.objective < outcome.objective)) return;
  found.before = outcome.before;
  found.objective_start = outcome.objective_start;
  outcome = std::move(found);
}

}  // namespace

void bound_by_relaxation(const DesignProblem& problem, DesignOutcome& outcome,
                         const std::function<DesignOutcome(const DesignProblem&)>& again) {
  if (!is_open(problem, outcome)) return;
  const Branching all(problem, 0);
  const Branch root = all.root();
  DiscreteBounds bounds(problem);
  const DiscreteBounds::Answer bound = bounds(root, all.narrowed(root), Wanted::exact);
  if (!bound.known) return;
  if (outcome.status == DesignStatus::compromise) {
    if (bound.possible || !outcome.unmet_fixed.empty()) return;
    outcome.status = DesignStatus::impossible;
    outcome.proved = true;
    outcome.reason = "no masses and first moments within the bounds of the free numbers meet the conditions";
    return;
  }
  if (!std::isfinite(bound.least)) return;
  const auto close = [&] { return outcome.objective - bound.least <= bound_falls_short * std::abs(outcome.objective); };
  if (!close() && bound.x.size() > 0) improve(problem, bound.x, outcome, again);
  outcome.lower_bound = std::min(bound.least, outcome.objective);
  if (!close()) return;
  outcome.optimality = Optimality::proved_best;
  outcome.effort.end = SearchEffort::End::proof;
}

}  // namespace balance::designing
