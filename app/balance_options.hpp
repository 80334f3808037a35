#pragma once
/// Options shared by `balance conditions` and `balance design`: goals and strategy.

#include "balance/interface/reports/balance_request.hpp"
#include "balance/interface/reports/report_data.hpp"
#include "cli/command.hpp"

#include <cstdint>
#include <optional>

namespace balance::app {

struct GoalOptions {
  std::vector<std::string> goals;  ///< names; empty: the spec's
  std::string strategy = "complete";
  std::optional<std::uint64_t> seed;
  std::vector<std::string> without;  ///< elements that the goals ignore, as typed: comma-separated names
};

void add_goal_options(CLI::App& parser, GoalOptions& options);

/// What must be specified if no goal is given.
enum class GoalRequirement {
  goal,
  goal_or_objective,  ///< a goal or something to minimize
  none
};

/// The goals given by the options or, if there are none, those of the spec.
/// @throws UsageError for an unknown goal, or if there is no goal although one is required
std::vector<Goal> choose_goals(const GoalOptions& options, const Study& study,
                               GoalRequirement requirement = GoalRequirement::goal);

/// The names of the elements that the goals ignore.
/// @throws UsageError for a name that is neither a section nor an element of one
std::vector<std::string> choose_excluded_elements(const GoalOptions& options, const Mechanism& mechanism);

/// @throws UsageError unless the strategy is `complete` or `modular`
bool is_modular(const GoalOptions& options);

/// Collects all of the options above in a request. Throws what they throw.
reports::BalanceRequest make_balance_query(const GoalOptions& options, const Study& study,
                                           GoalRequirement requirement = GoalRequirement::goal);

// Conditions and designs for the commands. Failures become exceptions of the program.

/// The conditions of the goals given by the options or, if there are none, those of the spec.
/// @param named whether to name coefficients after the lengths that they consist of
/// @param speeds in whose derivatives they are stated; empty: none are chosen
/// @throws UsageError as make_balance_query; MechanismFailure if the conditions cannot be derived
reports::ConditionsReportData derive_conditions_or_throw(const GoalOptions& goal, const DesignSpace& space,
                                                         bool named = true,
                                                         std::vector<model::GeneralisedSpeed> speeds = {});

/// @throws MechanismFailure if the mechanism has no design; SpecError if the design section of the spec is invalid
DesignReport design_or_throw(const DesignSpace& space, const DesignStudyOptions& options);

/// @throws MechanismFailure if the spec, read back, does not reproduce the design
std::string designed_spec_or_throw(const DesignSpace& space, const DesignReport& report);

}  // namespace balance::app
