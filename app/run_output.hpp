#pragma once
/// What commands that run a mechanism tell and write.

#include "simulate_options.hpp"

#include "balance/result/result.hpp"

namespace balance::app {

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
