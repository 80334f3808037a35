#pragma once
/// The runs that `balance plot` draws and `balance compare` compares.

#include "balance/interface/files/result_file.hpp"
#include "balance/mechanics/model/mechanism.hpp"

#include <CLI/CLI.hpp>

#include <optional>
#include <string>
#include <vector>

namespace balance::app {

/// Adds the operands of a command that reads runs.
CLI::Option* add_run_operands(CLI::App& parser, std::vector<std::string>& runs);

/// @throws UsageError if more than one name refers to standard input
void check_standard_input_once(const std::vector<std::string>& names);

/// What a command can do with: motions, or also a single state, such as that of a spec without a motion.
enum class AcceptedRuns { motions, motions_and_states };

/// Reads a result file, or simulates a spec (`arm.yaml`, `arm.yaml:trajectory`) along the named trajectory or its first
/// one. The group of a simulated run is the trajectory given in `name`.
/// @param output file that will be written and must not be one of the inputs
/// @param what description of the output: "the picture"
/// @param accepted with states, a spec without a motion gives the state in which it is assembled, at rest
/// @throws SystemError for a file that cannot be read; SpecError; UsageError for an unknown trajectory or an output
/// that would replace an input; MotionFailure
files::StoredRun load_or_simulate_run(const std::string& name, const std::string& output, const std::string& what,
                                      AcceptedRuns accepted = AcceptedRuns::motions);

/// The mechanism of a run, from the spec in its file; of a run in a design file, with its free numbers.
/// @throws SpecError for a spec that cannot be read here, such as one whose tables are missing; SystemError if the run
/// does not belong to it
Mechanism read_run_mechanism(const files::StoredRun& run);

/// @throws SystemError if the run does not belong to the mechanism
void check_run_matches_mechanism(const files::StoredRun& run, const Mechanism& mechanism);

/// A spec together with one of its trajectories: `arm.yaml:cycloid`.
struct SpecTrajectoryName {
  std::string spec, trajectory;  ///< trajectory may be empty
};

/// std::nullopt if the name is not that of a spec. Standard input, `-`, counts as a spec without a trajectory. If a
/// file of this name exists, its colon does not separate a trajectory.
std::optional<SpecTrajectoryName> parse_spec_trajectory_name(const std::string& name);

/// Splits `arm.yaml:cycloid` into spec and trajectory. @throws UsageError if `trajectory` already names another one
void split_trajectory_name(std::string& spec, std::string& trajectory);

}  // namespace balance::app
