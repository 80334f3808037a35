#pragma once
/// The runs that `balance plot` draws and `balance compare` compares.

#include "balance/read/result_file.hpp"

#include <CLI/CLI.hpp>

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

}  // namespace balance::app
