#pragma once
/// What `balance tolerance` tells.

#include "balance/analysis/tolerance.hpp"
#include "balance/analysis/tolerance_at_rest.hpp"
#include "balance/analysis/tolerance_sampling.hpp"

#include <optional>
#include <string>
#include <vector>

namespace balance {

struct ToleranceView {
  std::string mechanism, trajectory;
  Tolerances numbers;
  std::optional<ToleranceReport> report;  ///< along the trajectory
  std::optional<SampledTolerance> sampling;
  std::optional<RestTolerance> at_rest;
  ToleranceDraws draws;
};

/// A number's name as people say it: "cw1.mass".
inline std::string tolerance_name(const ToleranceNumber& number) {
  return number.path.substr(number.path.find('.') + 1);
}

/// Numbers that open joints, and how far.
const std::vector<NumberOpening>& openings_of(const ToleranceView& view);

/// What the sampled standard deviation differs by from the first order's, in standard errors; NaN where one of them has none.
double disagreement(const ToleranceReport& report, const SampledFigure& sampled);

/// The deviation of one of a quantity's figures; null if the report does not have it.
const FigureDeviation* find_deviation(const ToleranceReport& report, const std::string& quantity, Figure figure);

}  // namespace balance
