#pragma once
/// A run and how far it is off as HDF5 that is also netCDF-4; docs/file-format.md describes the file.

#include "balance/present/tolerance_view.hpp"
#include "balance/study/study.hpp"
#include "balance/write/write_options.hpp"

#include <optional>
#include <string>
#include <vector>

namespace balance {

/// The run as the spec has it, as a result file; in the group `tolerance` the numbers, the figures' deviations and the standard deviation of
/// every sample. Draws are left out. Complete or not at all.
/// @throws std::invalid_argument if the view has no report along a trajectory; SystemError, Cancelled as write_result_hdf5
void write_tolerance(const std::string& path, const ToleranceReportData& view, const Provenance& description,
                     const WriteOptions& options = {});

/// What was asked for, as it would be asked of `balance tolerance`.
struct ToleranceCommand {
  std::vector<std::string> of;  ///< quantities; empty: all
  std::optional<long> samples;
  std::vector<std::string> set;  ///< `name=value`
};

/// @param trajectory one of the study's, perhaps with other samples
Provenance make_tolerance_provenance(const Study& study, const Trajectory& trajectory, const ToleranceCommand& call);

}  // namespace balance
