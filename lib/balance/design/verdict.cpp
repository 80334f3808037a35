#include "balance/design/verdict.hpp"

#include <fmt/format.h>

namespace balance::design {

namespace {

std::string count_with_noun(int n, const char* one, const char* many) {
  return fmt::format("{} {}", n, n == 1 ? one : many);
}

std::string summarise_search(const SearchBudget& budget, SearchTarget aim) {
  std::vector<std::string> parts;
  if (budget.starts > 0) parts.push_back(count_with_noun(budget.starts, "start", "starts"));
  if (budget.solutions > 0 && aim == SearchTarget::objective)
    parts.push_back(count_with_noun(budget.solutions, "exact design", "exact designs"));
  if (budget.geometries > 0) parts.push_back(count_with_noun(budget.geometries, "set of lengths", "sets of lengths"));
  if (budget.local_searches > 0)
    parts.push_back(
        count_with_noun(budget.local_searches, "local search", "local searches") +
        (budget.repeated_optima > 0 ? fmt::format(" ({} of them as good as the best)", budget.repeated_optima) : ""));
  if (budget.evaluations > 0) parts.push_back(count_with_noun(budget.evaluations, "evaluation", "evaluations"));
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : ", ") + part;
  return text;
}

SearchEffort make_search_effort(const SearchBudget& budget, SearchTarget aim, bool proved) {
  using End = SearchEffort::Termination;
  SearchEffort effort{
      budget.starts,     budget.local_searches, budget.repeated_optima > 0 ? budget.repeated_optima : -1,
      budget.geometries, budget.evaluations,    End::starts_exhausted};
  const bool any = budget.starts + budget.local_searches + budget.geometries + budget.evaluations > 0;
  effort.termination = proved                         ? End::proved
                       : budget.stopped               ? End::time_limit
                       : !any                         ? End::not_searched
                       : aim == SearchTarget::nothing ? End::goal_met
                                                      : End::starts_exhausted;
  return effort;
}

}  // namespace

void assess_optimality(const SolverContext& context, SearchTarget aim, bool proved, DesignOutcome& outcome) {
  outcome.search_summary = summarise_search(context.budget, aim);
  outcome.effort = make_search_effort(context.budget, aim, proved);
  if (aim == SearchTarget::nothing) {
    outcome.optimality = Optimality::not_optimised;
  } else if (proved) {
    outcome.optimality = Optimality::proved_global;
  } else if (context.budget.stopped) {
    outcome.optimality = Optimality::budget_exhausted;
  } else {
    outcome.optimality = Optimality::local_optimum;
  }
}

std::string undefined_objective_reason(const Objective& objective, const std::string& where,
                                       const std::string& trouble) {
  std::string reason = fmt::format("{} cannot be computed {}", objective.name, where);
  if (!trouble.empty()) reason += ": " + trouble;
  return reason;
}

}  // namespace balance::design
