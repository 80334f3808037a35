#pragma once
/// The runs that `balance plot` draws and `balance compare` compares.

#include "balance/interface/files/result_file.hpp"

#include <CLI/CLI.hpp>

#include <optional>
#include <string>
#include <vector>

namespace balance::app {

/// The operands of a command that reads runs.
CLI::Option* add_run_operands(CLI::App& parser, std::vector<std::string>& runs);

/// @throws UsageError if more than one of the names is standard input
void check_standard_input_once(const std::vector<std::string>& names);

/// A result file, or a spec (`arm.yaml`, `arm.yaml:trajectory`) that is run now, along its first trajectory if none is named.
/// The group of a spec's run is the trajectory that `name` names.
/// @param output that is to be written, none of what is read; @param what "the picture"
/// @throws SystemError for a file that cannot be read, SpecError, UsageError for a trajectory that does not exist or an output that
/// would replace what is read, MotionFailure
StoredRun load_or_simulate_run(const std::string& name, const std::string& output, const std::string& what);

/// Specs that are named with one of their trajectories: `arm.yaml:cycloid`.
struct SpecTrajectoryName {
  std::string spec, trajectory;  ///< the trajectory may be empty
};

/// Nothing if the name is none of a spec. Standard input, `-`, is one, of which no trajectory can be named. A file that has a colon in its
/// name is that file.
std::optional<SpecTrajectoryName> parse_spec_trajectory_name(const std::string& name);

/// Takes the trajectory off a spec's name. @throws UsageError if another is named already
void split_trajectory_name(std::string& spec, std::string& trajectory);

}  // namespace balance::app
