#pragma once
/// A Result as one table of comma-separated values.

#include "balance/result/result.hpp"
#include "balance/write/write_options.hpp"

#include <string>

namespace balance {

/// One row per sample; the first line names each column with its unit in brackets: `time [s],A1.position [rad],…`.
/// Numbers have 17 significant digits, enough to give back the same double. Written under a temporary name and
/// renamed when complete.
/// @throws SystemError, Cancelled, std::invalid_argument as write_result_hdf5
void write_result_csv(const std::string& path, const RunResult& result, const WriteOptions& options = {});

}  // namespace balance
