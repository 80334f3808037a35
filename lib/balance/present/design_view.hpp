#pragma once
/// Everything that is told about a design, gathered for the writers.

#include "balance/analysis/design_study.hpp"
#include "balance/present/conditions_view.hpp"

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

}  // namespace balance
