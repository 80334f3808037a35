#pragma once
/// Results of `balance tolerance` as text, JSON and HDF5.

#include "balance/interface/files/result_file.hpp"
#include "balance/interface/files/text_options.hpp"
#include "balance/motion/study/study.hpp"
#include "balance/synthesis/tolerance/tolerance_analysis.hpp"
#include "balance/synthesis/tolerance/tolerance_sampling.hpp"

#include <optional>
#include <string>
#include <vector>

namespace balance::reports {

struct ToleranceReportData {
  std::string mechanism, trajectory;
  Tolerances numbers;
  std::optional<tolerance::ToleranceReport> report;  ///< along the trajectory
  std::optional<tolerance::MonteCarloReport> sampling;
  std::optional<tolerance::StaticTolerance> at_rest;
  tolerance::MonteCarloOptions draws;
};

// A run and its deviations as HDF5 that is also netCDF-4; docs/file-format.md describes the file.

/// Writes the nominal run as a result file and, in the group `tolerance`, the numbers, the figures' deviations and the
/// standard deviation of every sample, but no draws. Writes the complete file or none.
/// @throws std::invalid_argument if the view has no report along a trajectory; SystemError,
/// Cancelled as write_result_hdf5
void write_tolerance(const std::string& path, const ToleranceReportData& view, const files::Provenance& description,
                     const files::WriteOptions& options = {});

/// Request as given to `balance tolerance`.
struct ToleranceCommand {
  std::vector<std::string> of;  ///< quantities; empty: all
  std::optional<long> samples;
};

/// @param trajectory one of the study's, possibly with other samples
files::Provenance make_tolerance_provenance(const Study& study, const Trajectory& trajectory,
                                            const ToleranceCommand& command);

// Deviations of runs due to tolerances, as JSON and as text.

/// Deviations are null if a figure has none to first order, as are contributions of numbers that open a joint.
/// `sampling` and `at_rest` are null if they were not requested.
std::string tolerance_json(const ToleranceReportData& view);

/// Deviations of runs due to tolerances, as text.
std::string tolerance_text(const ToleranceReportData& view, const files::TextOptions& options = {});

}  // namespace balance::reports
