#pragma once
/// `balance design` of a spec that asks for a trade-off.

#include "design_options.hpp"
#include "exit_code.hpp"

#include "balance/analysis/front_study.hpp"

namespace balance::app {

/// The spec asks for a front, and the command line for nothing else.
bool is_front_requested(const DesignCommandOptions& options, const Study& study);

/// Refuses options of fronts for other designs, and the other way round. @throws UsageError
void check_front_options(const DesignCommandOptions& options, const Study& study);

/// Finds the front, prints it or one of its designs, and writes files.
ExitCode run_front(const DesignCommandOptions& options, const DesignSpace& space);

/// @throws SpecError if the spec asks for what makes no sense
ParetoFront find_front_or_throw(const DesignSpace& space, const DesignStudyOptions& options);

}  // namespace balance::app
