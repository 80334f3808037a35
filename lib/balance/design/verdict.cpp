#include "balance/design/verdict.hpp"

#include <fmt/format.h>

namespace balance::designing {

namespace {

std::string counted(int n, const char* one, const char* many) { return fmt::format("{} {}", n, n == 1 ? one : many); }

std::string list_what_was_tried(const Budget& budget, Aim aim) {
  std::vector<std::string> parts;
  if (budget.starts > 0) parts.push_back(counted(budget.starts, "start", "starts"));
  if (budget.solutions > 0 && aim == Aim::objective)
    parts.push_back(counted(budget.solutions, "exact design", "exact designs"));
  if (budget.geometries > 0) parts.push_back(counted(budget.geometries, "set of lengths", "sets of lengths"));
  if (budget.descents > 0)
    parts.push_back(counted(budget.descents, "local search", "local searches") +
                    (budget.alike > 0 ? fmt::format(" ({} of them as good as the best)", budget.alike) : ""));
  if (budget.evaluations > 0) parts.push_back(counted(budget.evaluations, "evaluation", "evaluations"));
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : ", ") + part;
  return text;
}

SearchEffort effort_of(const Budget& budget, Aim aim, bool proved) {
  using End = SearchEffort::End;
  SearchEffort effort{budget.starts,     budget.descents,    budget.alike > 0 ? budget.alike : -1,
                      budget.geometries, budget.evaluations, End::starts};
  const bool any = budget.starts + budget.descents + budget.geometries + budget.evaluations > 0;
  effort.end = proved                ? End::proof
               : budget.stopped      ? End::time
               : !any                ? End::nothing
               : aim == Aim::nothing ? End::met
                                     : End::starts;
  return effort;
}

}  // namespace

void judge(const Context& context, Aim aim, bool proved, DesignOutcome& outcome) {
  outcome.tried = list_what_was_tried(context.budget, aim);
  outcome.effort = effort_of(context.budget, aim, proved);
  if (aim == Aim::nothing) {
    outcome.optimality = Optimality::not_asked;
  } else if (proved) {
    outcome.optimality = Optimality::proved_best;
  } else if (context.budget.stopped) {
    outcome.optimality = Optimality::stopped;
  } else {
    outcome.optimality = Optimality::local_best;
  }
}

std::string without_value(const Objective& objective, const std::string& where, const std::string& trouble) {
  std::string reason = fmt::format("{} cannot be computed {}", objective.name, where);
  if (!trouble.empty()) reason += ": " + trouble;
  return reason;
}

}  // namespace balance::designing
