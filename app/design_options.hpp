#pragma once
/// What the user asks of `balance design`, and what it means for the library.

#include "balance/interface/files/result_file.hpp"
#include "balance/synthesis/design/design_study.hpp"
#include "balance/synthesis/design/pareto_front.hpp"
#include "balance_options.hpp"
#include "cli/failures.hpp"

#include <string>

namespace balance::app {

struct DesignCommandOptions {
  SpecOptions spec;
  GoalOptions goal;
  std::string output, h5;  ///< files to write; empty: none
  std::string csv;         ///< of a front
  std::string point;       ///< of a front: its number or `middle`; empty: the front alone
  std::string minimize;    ///< YAML; empty: the spec's
  std::string algorithm;   ///< one of SearchOptions' global or local ones; empty: the spec's
  double seconds = 0;      ///< 0: the spec's
  int starts = 0;          ///< 0: the spec's
  bool force = false;
  bool quiet = false;
};

void add_design_options(CLI::App& parser, DesignCommandOptions& options);

/// @throws UsageError for names that do not exist; SpecError if nothing is free
DesignStudyOptions make_study_options(const DesignCommandOptions& options, const Study& study);

/// Refuses at once what would fail after the computation. @throws UsageError, SystemError
void check_outputs(const DesignCommandOptions& options, const Study& study);

Provenance describe(const DesignCommandOptions& options, const Study& study);

// `balance design` of a spec that asks for a trade-off.

/// The spec asks for a front, and the command line for nothing else.
bool is_front_requested(const DesignCommandOptions& options, const Study& study);

/// Refuses options of fronts for other designs, and the other way round. @throws UsageError
void check_front_options(const DesignCommandOptions& options, const Study& study);

/// Finds the front, prints it or one of its designs, and writes files.
ExitCode run_front(const DesignCommandOptions& options, const DesignSpace& space);

/// @throws SpecError if the spec asks for what makes no sense
ParetoFront find_front_or_throw(const DesignSpace& space, const DesignStudyOptions& options);

}  // namespace balance::app
