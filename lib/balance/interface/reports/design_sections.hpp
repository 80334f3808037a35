#pragma once
/// Report data of a design.

#include "balance/interface/files/json.hpp"
#include "balance/interface/files/result_file.hpp"
#include "balance/interface/files/text_options.hpp"
#include "balance/interface/reports/conditions_sections.hpp"
#include "balance/synthesis/design/design_study.hpp"

#include <optional>
#include <string>
#include <vector>

namespace balance::reports {

struct DesignReportData {
  DesignReport report;
  std::string objective;            ///< "added mass", "0.5 rms(torque) along cycloid + added mass"; empty: none
  std::string objective_unit;       ///< "" for a sum
  ConditionsReportData conditions;  ///< at the designed geometry; residuals of the designed mechanism
  VectorX residuals_before;         ///< of the mechanism before; NaN if its geometry has other conditions
  std::vector<std::string> trajectories = {};  ///< that the objective and the limits name; empty: none
  double seconds = 0;                          ///< time limit of the search [s]
  std::optional<double> interrupted = {};      ///< time at which it was interrupted [s]
  std::vector<std::string> warnings;
};

/// Text of the objective.
std::string objective_text(const std::vector<ObjectiveTerm>& terms);

/// One figure of one quantity, before and after.
struct MetricChange {
  std::string quantity, unit, figure;  ///< "torque[A1]", "N m", "peak"
  double before = 0, after = 0;        ///< exactly zero instead of round-off; NaN: the run failed
};

/// Peak and rms of torques, shaking force and shaking moment.
std::vector<MetricChange> list_metric_changes(const design::TrajectoryComparison& comparison);

/// Elements that a design leaves out, with their place in the spec, for format_balanced_spec().
std::vector<study::OptionalElementText> list_omitted_elements(const DesignReport& report);

// A design as HDF5 that is also netCDF-4; docs/file-format.md describes the file.

/// Writes numbers, conditions and, in the groups `before/<trajectory>` and `after/<trajectory>`, the runs.
/// Writes the complete file or none.
/// @param description of the spec and the command; its trajectory is ignored
/// @throws SystemError, Cancelled as write_result_hdf5
void write_design(const std::string& path, const DesignReportData& view, const files::Provenance& description,
                  const files::WriteOptions& options = {});

// A design as JSON for programs.

/// One object with everything in the view, and the files written.
Json design_json(const DesignReportData& view, const std::vector<std::string>& files);

// A design as text for people.

/// What the design achieves and what limits it, the free numbers, the conditions, the cost of the design and its gain
/// along the trajectories that the objective and the limits name; along all of them if none is named or the options are
/// verbose. Ends with a line feed.
std::string design_text(const DesignReportData& view, const files::TextOptions& options = {});

}  // namespace balance::reports
