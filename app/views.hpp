#pragma once
/// Conditions and designs with everything that is told about them: shared by `conditions`, `design` and `report`.

#include "goals.hpp"

#include "balance/analysis/design_study.hpp"
#include "balance/present/design_view.hpp"

namespace balance::app {

/// The conditions of the goals with the names of their coefficients, judged with the numbers that the study holds.
/// @param named whether coefficients get the names of the lengths that they are made of
/// @throws MechanismFailure if there are none to derive
ConditionsView derive_view(const GoalOptions& goal, const SpecOptions& spec, const DesignSpace& space,
                           bool named = true);

/// @throws MechanismFailure if the mechanism has no design; SpecError if the spec asks for what makes no sense
DesignReport design_or_throw(const DesignSpace& space, const DesignStudyOptions& options);

/// @param balanced the text of the designed spec
DesignView make_view(const GoalOptions& goal, const DesignStudyOptions& study_options, const DesignSpace& space,
                     const std::string& balanced, DesignReport report);

}  // namespace balance::app
