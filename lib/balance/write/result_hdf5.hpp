#pragma once
/// A Result as HDF5 that is also netCDF-4; docs/file-format.md describes the file.

#include "balance/result/result.hpp"
#include "balance/write/write_options.hpp"

#include <string>

namespace balance {

/// Writes the file under a temporary name and renames it when it is complete. The same result and description give the
/// same bytes. The samples are written from where they are.
/// @param result of a run that is done, or of one under control that ended early
/// @throws SystemError with path and reason; an older file of that name is then as it was
/// @throws Cancelled if options.cancelled says so
/// @throws std::invalid_argument if the result is neither, has no samples, or its sizes contradict each other
void write_result_hdf5(const std::string& path, const RunResult& result, const Provenance& description,
                       const WriteOptions& options = {});

}  // namespace balance
