#pragma once
/// What the user asks of `balance simulate`, and what it means for the study.

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
  bool poses = false;  ///< of the bodies, too
  bool split = false;  ///< what the torques add up from, too
  bool quiet = false;
  StateOptions state;  ///< a single one, instead of a run; its `at` is empty: none. Its trajectory is the one above
};

/// What `balance control` has too.
void add_run_options(CLI::App& parser, SimulateOptions& options);

void add_simulate_options(CLI::App& parser, SimulateOptions& options);

/// The trajectory that the options name, with their changes.
/// @throws UsageError if there is none of that name or a change makes no sense; SpecError if the spec has no motion
Trajectory choose_trajectory(const SimulateOptions& options, const Study& study);

/// What a single state is looked at with: its moments' point and length of time are those of the trajectory that the options name,
/// if the spec has one. @throws UsageError
InverseOptions choose_state_options(const SimulateOptions& options, const Study& study);

/// @throws UsageError if there is no such formulation, or not for this mechanism
void check_formulation(const SimulateOptions& options, const Study& study);

/// Refuses at once what would fail after the computation. @throws UsageError, SystemError
void check_outputs(const SimulateOptions& options, const Study& study);

Provenance describe(const SimulateOptions& options, const Study& study, const Trajectory& trajectory);

/// The same of a single state.
Provenance describe_state(const SimulateOptions& options, const Study& study);

/// What the user asks of `balance control`: what `balance simulate` is asked, and a controller.
struct ControlCommandOptions {
  SimulateOptions run;
  std::string controller;  ///< empty: the first of the spec, or computed torque
  double settle = 0;       ///< [s]
  long steps = 0;          ///< that the integration may take; 0: the default
};

void add_control_options(CLI::App& parser, ControlCommandOptions& options);

/// The study's controller of this name; without a name the spec's first or, if it lists none, computed torque.
/// @throws UsageError if there is none of that name
Controller find_controller(const std::string& name, const Study& study);

/// The controller that the options name.
/// @throws UsageError if there is none of that name
Controller choose_controller(const ControlCommandOptions& options, const Study& study);

Provenance describe(const ControlCommandOptions& options, const Study& study, const Trajectory& trajectory,
                    const Controller& controller);

// What commands that run a mechanism tell and write.

/// On stderr unless --quiet: the spec's warnings, and which trajectory was taken if none was named.
void print_run_header(const SimulateOptions& options, const Study& study, const Trajectory& trajectory);

/// On stderr unless --quiet: what the result should not be read without.
void print_notes(const SimulateOptions& options, const RunResult& result);

/// Writes the files asked for and names them. Signals wait until the file is complete or gone. @throws SystemError, Cancelled
std::vector<std::string> write_files(const SimulateOptions& options, const RunResult& result,
                                     const Provenance& description);

/// On stdout: the metrics as JSON if asked for, else in words unless --quiet. @param files that were written
void print_result(const SimulateOptions& options, const RunResult& result, const Provenance& description,
                  const std::vector<std::string>& files);

}  // namespace balance::app
