#pragma once
/// What `balance tolerance` tells.

#include "balance/interface/files/result_file.hpp"
#include "balance/motion/study/study.hpp"
#include "balance/synthesis/tolerance/tolerance_analysis.hpp"
#include "balance/synthesis/tolerance/tolerance_sampling.hpp"

#include <optional>
#include <string>
#include <vector>

namespace balance {

struct ToleranceReportData {
  std::string mechanism, trajectory;
  Tolerances numbers;
  std::optional<ToleranceReport> report;  ///< along the trajectory
  std::optional<MonteCarloReport> sampling;
  std::optional<StaticTolerance> at_rest;
  MonteCarloOptions draws;
};

/// A number's name as people say it: "cw1.mass".
inline std::string tolerance_name(const TolerancedParameter& number) {
  return number.path.substr(number.path.find('.') + 1);
}

/// Numbers that open joints, and how far.
const std::vector<IncompatibleParameter>& incompatible_parameters_of(const ToleranceReportData& view);

/// What the sampled standard deviation differs by from the first order's, in standard errors; NaN where one of them has none.
double sampling_disagreement(const ToleranceReport& report, const SampledFigure& sampled);

/// The deviation of one of a quantity's figures; null if the report does not have it.
const FigureDeviation* find_deviation(const ToleranceReport& report, const std::string& quantity, Statistic figure);

// A run and how far it is off as HDF5 that is also netCDF-4; docs/file-format.md describes the file.

/// The run as the spec has it, as a result file; in the group `tolerance` the numbers, the figures' deviations and the standard deviation
/// of every sample. Draws are left out. Complete or not at all.
/// @throws std::invalid_argument if the view has no report along a trajectory; SystemError, Cancelled as write_result_hdf5
void write_tolerance(const std::string& path, const ToleranceReportData& view, const Provenance& description,
                     const WriteOptions& options = {});

/// What was asked for, as it would be asked of `balance tolerance`.
struct ToleranceCommand {
  std::vector<std::string> of;  ///< quantities; empty: all
  std::optional<long> samples;
};

/// @param trajectory one of the study's, perhaps with other samples
Provenance make_tolerance_provenance(const Study& study, const Trajectory& trajectory, const ToleranceCommand& call);

// How far runs are off when a mechanism's numbers are, as JSON.

/// Deviations are null where a figure has none to first order, and so are parts of numbers that open a joint; `sampling` and `at_rest`
/// where nobody asked.
std::string tolerance_json(const ToleranceReportData& view);

/// How far runs are off when a mechanism's numbers are, for people.
std::string tolerance_text(const ToleranceReportData& view);

}  // namespace balance
