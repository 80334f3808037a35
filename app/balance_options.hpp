#pragma once
/// What `balance conditions` and `balance design` share: goals and the strategy.

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
  std::vector<std::string> without;  ///< what the goals leave out, as written: names joined by commas
};

void add_goal_options(CLI::App& parser, GoalOptions& options);

/// What is asked for where there is no goal.
enum class GoalRequirement {
  goal,
  goal_or_objective,  ///< a goal or something to minimize
  none
};

/// The goals that the options name, or else the spec's.
/// @throws UsageError for a name that does not exist, or if there is no goal at all although something is needed
std::vector<Goal> choose_goals(const GoalOptions& options, const Study& study,
                               GoalRequirement without = GoalRequirement::goal);

/// The names of what the goals leave out.
/// @throws UsageError for a name that is neither a section nor in one
std::vector<std::string> choose_excluded_elements(const GoalOptions& options, const Mechanism& mechanism);

/// @throws UsageError unless the strategy is `complete` or `modular`
bool is_modular(const GoalOptions& options);

/// All of these.
BalanceRequest make_balance_query(const GoalOptions& options, const Study& study,
                                  GoalRequirement without = GoalRequirement::goal);

// Conditions and designs as commands need them: there, or a failure of the program.

/// The conditions of the goals that the options name, or else the spec's.
/// @param named whether coefficients get the names of the lengths that they are made of
/// @throws UsageError as make_balance_query; MechanismFailure if there are none to derive
ConditionsReportData derive_conditions_or_throw(const GoalOptions& goal, const DesignSpace& space, bool named = true);

/// @throws MechanismFailure if the mechanism has no design; SpecError if the spec asks for what makes no sense
DesignReport design_or_throw(const DesignSpace& space, const DesignStudyOptions& options);

/// @throws MechanismFailure if what was read back is not the design
std::string designed_spec_or_throw(const DesignSpace& space, const DesignReport& report);

}  // namespace balance::app
