#pragma once
/// What `balance tolerance` tells.

#include "balance/analysis/tolerance.hpp"
#include "balance/analysis/tolerance_at_rest.hpp"
#include "balance/analysis/tolerance_sampling.hpp"

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

}  // namespace balance
