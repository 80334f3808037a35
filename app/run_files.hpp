#pragma once
/// The files that a run is written to.

#include "simulate_options.hpp"

#include "balance/study/result.hpp"

namespace balance::app {

/// Writes the files asked for and names them. Signals wait until the file is complete or gone. @throws SystemError, Cancelled
std::vector<std::string> write_files(const SimulateOptions& options, const Result& result,
                                     const FileDescription& description);

}  // namespace balance::app
