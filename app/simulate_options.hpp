#pragma once
/// What the user asks of `balance simulate`, and what it means for the study.

#include "command.hpp"
#include "pose_options.hpp"

#include "balance/write/write_options.hpp"

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

}  // namespace balance::app
