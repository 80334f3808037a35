#include "goals.hpp"

#include "failure.hpp"
#include "suggestion.hpp"

#include "balance/conditions/modular.hpp"
#include "balance/read/nearest.hpp"
#include "balance/study/start_pose.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace balance::app {
namespace {

const std::vector<std::string> strategies = {"complete", "modular"};

}  // namespace

void add_goal_options(CLI::App& parser, GoalOptions& o) {
  CLI::Option* goal = parser.add_option("-g,--goal", o.goals,
                                        fmt::format("{}; may be repeated: all of them", fmt::join(goal_names(), ", ")));
  suggest_words(goal->type_name("GOAL")->allow_extra_args(false), goal_names());
  CLI::Option* strategy =
      parser.add_option("--strategy", o.strategy, "complete: necessary and sufficient; modular: each chain by itself");
  suggest_words(strategy->type_name("NAME")->capture_default_str(), strategies);
  parser.add_option("--seed", o.seed, "of random configurations and searches")->type_name("N");
}

std::vector<Goal> choose_goals(const GoalOptions& options, const Study& study, bool needed) {
  std::vector<Goal> goals;
  for (const std::string& name : options.goals) {
    const std::optional<Goal> goal = find_goal(name);
    if (!goal) {
      throw UsageError(fmt::format("--goal {}: expected {}{}", read::in_quotes(name), read::one_of(goal_names()),
                                   read::nearest_hint(name, goal_names())));
    }
    if (std::find(goals.begin(), goals.end(), *goal) == goals.end()) goals.push_back(*goal);
  }
  if (goals.empty()) goals = study.design.goals;
  if (goals.empty() && needed) {
    throw UsageError(
        fmt::format("{} has no design: goal, so --goal is needed: {}", study.spec_file, read::one_of(goal_names())));
  }
  return goals;
}

bool is_modular(const GoalOptions& options) {
  if (std::find(strategies.begin(), strategies.end(), options.strategy) == strategies.end()) {
    throw UsageError(fmt::format("--strategy {}: expected {}{}", read::in_quotes(options.strategy),
                                 read::one_of(strategies), read::nearest_hint(options.strategy, strategies)));
  }
  return options.strategy == "modular";
}

Derive make_derive(const std::vector<Goal>& goals, bool modular, const ConditionOptions& options,
                   const std::vector<CoordinateValue>& start) {
  return [=](const Mechanism& any) {
    const Mechanism mechanism = assembled_at(any, start);
    return modular ? derive_modular_conditions(mechanism, goals, options)
                   : derive_conditions(mechanism, goals, options);
  };
}

}  // namespace balance::app
