#pragma once
/// A design as HDF5 that is also netCDF-4; docs/file-format.md describes the file.

#include "balance/present/design_view.hpp"
#include "balance/write/write_options.hpp"

#include <string>

namespace balance {

/// Numbers, conditions and, in groups `before/<trajectory>` and `after/<trajectory>`, the runs. Complete or not at all.
/// @param description of the spec and the command; what it says of a trajectory is not used
/// @throws SystemError, Cancelled as write_result_hdf5
void write_design(const std::string& path, const DesignReportData& view, const Provenance& description,
                  const WriteOptions& options = {});

}  // namespace balance
