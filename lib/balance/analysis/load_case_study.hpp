#pragma once
/// One design for one load, and one for several. Private to analysis.

#include "balance/analysis/design_study.hpp"

namespace balance {

/// What a spec asks a design for with its own load.
/// @param space must outlive the problem, and so must the terms of the options
/// @throws std::invalid_argument as design_study
DesignProblem state_problem(const DesignSpace& space, const DesignStudyOptions& options);

/// Studies, masses and inertias before and after, of the report's numbers.
void measure_design(const DesignSpace& space, DesignReport& report);

/// Runs every trajectory before and after.
void compare_trajectories(DesignReport& report);

/// Fills outcome, load_cases and adaptive of a report on a study with load cases; without an outcome (unsolved) nothing else.
/// @throws std::invalid_argument as design_study
void study_load_cases(const DesignSpace& space, const DesignStudyOptions& options, DesignReport& report);

}  // namespace balance
