#pragma once
/// Options of `balance design` and their translation into options of the library.

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
  std::string output, h5;   ///< files to write; empty: none
  std::string certificate;  ///< the proof of the bound over all lengths; empty: none
  std::string csv;          ///< table of a front's points
  std::string point;        ///< of a front: the number of a point, or `middle`; empty: the whole front
  std::string minimize;     ///< YAML; empty: the spec's
  std::string algorithm;    ///< one of the global or local algorithms of SearchOptions; empty: the spec's
  double seconds = 0;       ///< 0: the spec's
  int starts = 0;           ///< 0: the spec's
  bool force = false;
  bool quiet = false;
};

/// --seconds, also of commands that design among other things.
void add_seconds_option(CLI::App& parser, double& seconds);

void add_design_options(CLI::App& parser, DesignCommandOptions& options);

/// @throws UsageError for unknown names; SpecError if no number is free
DesignStudyOptions make_study_options(const DesignCommandOptions& options, const Study& study);

/// Checks before the computation that the outputs can be written. @throws UsageError, SystemError
void check_outputs(const DesignCommandOptions& options, const Study& study);

files::Provenance describe(const DesignCommandOptions& options, const Study& study);

// `balance design` for a spec that asks for a Pareto front.

/// Whether the spec asks for a front and the command line does not override it with --minimize.
bool is_front_requested(const DesignCommandOptions& options, const Study& study);

/// Rejects front options without a front, and --output of a front without --point. @throws UsageError
void check_front_options(const DesignCommandOptions& options, const Study& study);

/// Computes the front, prints it or one of its designs, and writes the files.
ExitCode run_front(const DesignCommandOptions& options, const DesignSpace& space);

/// @throws MechanismFailure if the front is empty because of a failure; SpecError if the design section of the spec is
/// invalid
design::ParetoFront find_front_or_throw(const DesignSpace& space, const DesignStudyOptions& options);

}  // namespace balance::app
