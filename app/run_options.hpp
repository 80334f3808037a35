#pragma once
/// Options of `balance simulate` and their effect on the study.

#include "balance/interface/files/provenance.hpp"
#include "balance/interface/files/result_file.hpp"
#include "balance/mechanics/results/result.hpp"
#include "cli/command.hpp"
#include "state_options.hpp"

#include <optional>
#include <string>

namespace balance::app {

struct SimulateOptions {
  SpecOptions spec;
  std::string trajectory;   ///< empty: the first of the spec
  std::string output, csv;  ///< files to write; empty: none
  std::string about;        ///< "x,y" or "x,y,z" [m]; empty: as in the spec
  std::optional<long> samples;
  std::optional<double> duration;  ///< [s]
  std::string formulation = "tree";
  bool force = false;
  bool compress = false;
  bool poses = false;                 ///< also write the poses of the bodies
  std::optional<int> orders;          ///< highest order of quantities at constant speed
  std::optional<double> fluctuation;  ///< coefficient of the speed that a flywheel is wanted for
  bool split = false;                 ///< also write the contributions to each torque
  bool quiet = false;
  StateOptions state;  ///< a single state instead of a run, unless its `at` is empty; uses the trajectory above
};

/// Options shared with `balance control`.
void add_run_options(CLI::App& parser, SimulateOptions& options);

void add_simulate_options(CLI::App& parser, SimulateOptions& options);

/// The trajectory chosen by the options, with their changes applied.
/// @throws UsageError if no trajectory has this name or a change is invalid; SpecError if the spec has no motion
Trajectory choose_trajectory(const SimulateOptions& options, const Study& study);

/// Options for the analysis of a single state. The moment reference point and the time scale come from the trajectory
/// chosen by the options, if the spec has one. @throws UsageError
InverseOptions choose_state_options(const SimulateOptions& options, const Study& study);

/// @throws UsageError if the formulation is unknown or does not support this mechanism
void check_formulation(const SimulateOptions& options, const Study& study);

/// Checks before the computation that the outputs can be written. @throws UsageError, SystemError
void check_outputs(const SimulateOptions& options, const Study& study);

/// What `simulate`, or `control` without its controller, was called with.
files::SimulateCommand make_simulate_command(const SimulateOptions& options, const Trajectory& trajectory);

files::Provenance describe(const SimulateOptions& options, const Study& study, const Trajectory& trajectory);

/// The same for a single state.
files::Provenance describe_state(const SimulateOptions& options, const Study& study);

/// Options of `balance control`: those of `balance simulate` plus a controller.
struct ControlCommandOptions {
  SimulateOptions run;
  std::string controller;  ///< empty: the first of the spec, or computed torque if it has none
  double settle = 0;       ///< [s]
  long steps = 0;          ///< maximum number of integration steps; 0: the default
};

void add_control_options(CLI::App& parser, ControlCommandOptions& options);

files::Provenance describe(const ControlCommandOptions& options, const Study& study, const Trajectory& trajectory,
                           const Controller& controller);

// Messages and files of the commands that run a mechanism.

/// Prints to stderr, unless --quiet: the warnings of the spec, and the chosen trajectory if none was named.
void print_run_header(const SimulateOptions& options, const Study& study, const Trajectory& trajectory);

/// Prints to stderr, unless --quiet: notes that are essential for reading the result.
void print_notes(const SimulateOptions& options, const RunResult& result);

/// Writes the requested files and returns their names. Signals are deferred until each file is complete or removed.
/// @throws SystemError, Cancelled
std::vector<std::string> write_files(const SimulateOptions& options, const RunResult& result,
                                     const files::Provenance& description);

/// Prints the metrics to stdout: as JSON if requested, else as text unless --quiet. @param files that were written
void print_result(const SimulateOptions& options, const Study& study, const RunResult& result,
                  const files::Provenance& description, const std::vector<std::string>& files);

}  // namespace balance::app
