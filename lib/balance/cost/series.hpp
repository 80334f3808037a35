#pragma once
/// Figures of one scalar or vector along a trajectory, and of the worst of several. Private to cost.

#include "balance/cost/row_space.hpp"
#include "balance/cost/sample_figures.hpp"

#include <optional>
#include <vector>

namespace balance {

struct CostSeries {
  RowSpace space;                         ///< of the parameters and a one behind them
  std::optional<SampledFigures> samples;  ///< needed for figures other than rms

  /// @param gradient with respect to the parameters, if not null; it has their size
  double figure(Statistic figure, const VectorX& parameters, VectorX* gradient) const;

 private:
  VectorX coordinates(const VectorX& parameters) const;
};

/// The largest figure of several series, with the gradient of that one.
/// @param series at least one
CostFunction make_max_cost(Statistic figure, std::vector<CostSeries> series, Eigen::Index parameters);

}  // namespace balance
