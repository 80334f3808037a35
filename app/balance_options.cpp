#include "balance_options.hpp"
#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/reports/designed_spec.hpp"
#include "balance/interface/specification/spec_locations.hpp"
#include "balance/motion/study/study.hpp"
#include "balance/synthesis/conditions/known_terms.hpp"
#include "cli/failures.hpp"
#include "cli/help.hpp"
#include "cli/validators.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace balance::app {

reports::ConditionsReportData derive_conditions_or_throw(const GoalOptions& goal, const DesignSpace& space, bool named,
                                                         std::vector<model::GeneralisedSpeed> speeds) {
  reports::BalanceRequest request = make_balance_query(goal, space.start);
  request.speeds = std::move(speeds);
  reports::ConditionsOutcome answer = derive_conditions_data(request, space, named);
  if (answer.refusal) throw MechanismFailure(answer.refusal.status, answer.refusal.reason);
  return std::move(answer.view);
}

DesignReport design_or_throw(const DesignSpace& space, const DesignStudyOptions& options) {
  try {
    DesignReport report = run_design_study(space, options);
    if (const reports::RequestFailure refusal = reports::find_failure(report))
      throw MechanismFailure(refusal.status, refusal.reason);
    return report;
  } catch (const std::invalid_argument& error) {
    // The options are valid, so the error is in the spec.
    throw SpecError({.place = specification::locate_key(space.start, "design"), .message = error.what()});
  }
}

std::string designed_spec_or_throw(const DesignSpace& space, const DesignReport& report) {
  reports::DesignedSpec spec = reports::format_designed_spec(space, report);
  if (spec.refusal) throw MechanismFailure(spec.refusal.status, spec.refusal.reason);
  return std::move(spec.text);
}

namespace {

const std::vector<std::string> strategies = {"complete", "modular"};
const std::vector<std::string> excludable_sections = {"friction", "loads",          "springs", "dampers",
                                                      "payloads", "counterweights", "discs"};

}  // namespace

void add_goal_options(CLI::App& parser, GoalOptions& o) {
  CLI::Option* goal = parser.add_option(
      "-g,--goal", o.goals,
      fmt::format("{}, or an order as in \"order 2 of shaking_force along run\"; repeat to require several",
                  fmt::join(study::goal_names(), ", ")));
  suggest_words(goal->type_name("GOAL")->allow_extra_args(false), study::goal_names());
  CLI::Option* strategy =
      parser.add_option("--strategy", o.strategy, "complete: necessary and sufficient; modular: each chain separately");
  suggest_words(strategy->type_name("NAME")->capture_default_str(), strategies);
  CLI::Option* without = parser.add_option(
      "--without", o.without, "what the goal ignores: friction, loads, springs, payloads, ... or names of elements");
  suggest_words(without->type_name("NAMES")->allow_extra_args(false), excludable_sections);
  parser.add_option("--seed", o.seed, "seed of random configurations and searches")
      ->type_name("N")
      ->check(integer_range_validator(0, study::max_seed));
}

std::vector<Goal> choose_goals(const GoalOptions& options, const Study& study, GoalRequirement requirement) {
  std::vector<Goal> goals;
  for (const std::string& name : options.goals) {
    if (const auto mistake = study::find_goal_mistake(name, study.mechanism, study.trajectories))
      throw UsageError(fmt::format("--goal {}: {}", quote_for_message(name), mistake->sentence()));
    const Goal goal = study::find_goal(name).value();
    if (std::find(goals.begin(), goals.end(), goal) == goals.end()) goals.push_back(goal);
  }
  if (goals.empty()) goals = study.design.goals;
  if (goals.empty() && requirement == GoalRequirement::goal) {
    throw UsageError(fmt::format("{} has no design: goal, so --goal is needed: {}", study.spec_file,
                                 join_alternatives(study::goal_names())));
  }
  if (goals.empty() && requirement == GoalRequirement::goal_or_objective) {
    throw UsageError(
        fmt::format("{} has neither design: goal nor design: minimize, so --goal ({}) or --minimize is needed",
                    study.spec_file, join_alternatives(study::goal_names())));
  }
  return goals;
}

std::vector<std::string> choose_excluded_elements(const GoalOptions& options, const Mechanism& mechanism) {
  const std::vector<std::string> known = conditions::list_excludable_names(mechanism);
  std::vector<std::string> names;
  for (const std::string& list : options.without) {
    for (std::size_t begin = 0, end = 0; end != std::string::npos; begin = end + 1) {
      end = list.find(',', begin);
      std::string name = list.substr(begin, end == std::string::npos ? end : end - begin);
      name.erase(0, name.find_first_not_of(' '));
      name.erase(name.find_last_not_of(' ') + 1);
      if (std::find(known.begin(), known.end(), name) == known.end())
        throw UsageError(fmt::format("--without {}: expected {}{}", quote_for_message(name), join_alternatives(known),
                                     append_nearest_name(name, known)));
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    }
  }
  return names;
}

bool is_modular(const GoalOptions& options) {
  if (std::find(strategies.begin(), strategies.end(), options.strategy) == strategies.end()) {
    throw UsageError(fmt::format("--strategy {}: expected {}{}", quote_for_message(options.strategy),
                                 join_alternatives(strategies), append_nearest_name(options.strategy, strategies)));
  }
  return options.strategy == "modular";
}

reports::BalanceRequest make_balance_query(const GoalOptions& options, const Study& study,
                                           GoalRequirement requirement) {
  return {.goals = choose_goals(options, study, requirement),
          .is_modular = is_modular(options),
          .seed = options.seed,
          .excluded = choose_excluded_elements(options, study.mechanism)};
}

}  // namespace balance::app
