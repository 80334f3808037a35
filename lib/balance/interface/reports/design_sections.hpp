#pragma once
/// Everything that is told about a design, gathered for the writers.

#include "balance/interface/files/json.hpp"
#include "balance/interface/files/result_file.hpp"
#include "balance/interface/reports/conditions_sections.hpp"
#include "balance/synthesis/design/design_study.hpp"

#include <optional>
#include <string>
#include <vector>

namespace balance {

struct DesignReportData {
  DesignReport report;
  std::string objective;  ///< "added mass", "0.5 rms(torque) along cycloid + added mass"; empty: nothing in particular
  std::string objective_unit;              ///< "" for a sum
  ConditionsReportData conditions;         ///< at the designed geometry; residuals of the designed mechanism
  VectorX residuals_before;                ///< of the mechanism before; NaN where its geometry has other conditions
  double seconds = 0;                      ///< that the search was allowed to take
  std::optional<double> interrupted = {};  ///< after so many seconds somebody ended it
  std::vector<std::string> warnings;
};

/// What is to be made small, in words.
std::string objective_text(const std::vector<ObjectiveTerm>& terms);
/// Its unit; empty for several terms.
std::string objective_unit(const std::vector<ObjectiveTerm>& terms, const Mechanism& mechanism);

/// Whether a free number ended at one of its bounds: −1 lower, 1 upper, 0 neither.
int active_bound(const FreeNumber& number, double value);

/// One figure of one quantity, before and after.
struct MetricChange {
  std::string quantity, unit, figure;  ///< "torque[A1]", "N m", "peak"
  double before = 0, after = 0;        ///< round-off is an exact zero; NaN: could not be moved
};

/// Peak and rms of torques, shaking force and shaking moment.
std::vector<MetricChange> list_metric_changes(const TrajectoryComparison& comparison);

// Which elements a design keeps, for people and programs.

/// "counterweights: cw1 and cw3 are kept, cw2 is left out", and what is known of the least count; empty without choices.
std::string format_optional_elements(const DesignReport& report);

/// Null without choices.
Json optional_elements_json(const DesignReport& report);

/// What a design leaves out, where it stands in the spec: for format_balanced_spec.
std::vector<OptionalElementText> list_omitted_elements(const DesignReport& report);

// A design as HDF5 that is also netCDF-4; docs/file-format.md describes the file.

/// Numbers, conditions and, in groups `before/<trajectory>` and `after/<trajectory>`, the runs. Complete or not at all.
/// @param description of the spec and the command; what it says of a trajectory is not used
/// @throws SystemError, Cancelled as write_result_hdf5
void write_design(const std::string& path, const DesignReportData& view, const Provenance& description,
                  const WriteOptions& options = {});

// A design as JSON for programs.

/// One object with everything of the view and the files written.
std::string design_json(const DesignReportData& view, const std::vector<std::string>& files);

// A design as text for people.

/// What was reached and why it is not more, the free numbers, the conditions, what the design costs and what every
/// trajectory gains. Ends with a line feed.
std::string design_text(const DesignReportData& view);

}  // namespace balance
