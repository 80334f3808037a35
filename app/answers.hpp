#pragma once
/// Conditions and designs as commands need them: there, or a failure of the program.

#include "goals.hpp"

#include "balance/answers/views.hpp"

namespace balance::app {

/// The conditions of the goals that the options name, or else the spec's.
/// @param named whether coefficients get the names of the lengths that they are made of
/// @throws UsageError as make_balance_query; MechanismFailure if there are none to derive
ConditionsReportData derive_conditions_or_throw(const GoalOptions& goal, const DesignSpace& space, bool named = true);

/// @throws MechanismFailure if the mechanism has no design; SpecError if the spec asks for what makes no sense
DesignReport design_or_throw(const DesignSpace& space, const DesignStudyOptions& options);

/// @throws MechanismFailure if what was read back is not the design
std::string designed_spec_or_throw(const DesignSpace& space, const DesignReport& report);

}  // namespace balance::app
