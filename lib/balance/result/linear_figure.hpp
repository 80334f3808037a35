#pragma once
/// Figures of a run as what they are of the parameters along one motion: sizes of rows times the parameters.

#include "balance/base/types.hpp"
#include "balance/result/figure.hpp"

#include <vector>

namespace balance {

/// A force or another quantity place by place along a motion.
struct AffineSeries {
  MatrixX rows;  ///< places · components × (parameters, one) [SI]: what does not depend on a parameter stands last
  Eigen::Index components = 1;  ///< rows of one place
  VectorX time_weights;         ///< per place: of the time average
};

/// weight · a convex function of the parameters.
struct AffineFigure {
  double weight = 1;
  VectorX coefficients;               ///< of the parameters, if it is a sum of them; else empty
  Statistic figure = Statistic::rms;  ///< rms or peak
  std::vector<AffineSeries> series;   ///< the worst of them counts

  /// Without the weight. @param parameters [SI], a one behind them
  double operator()(const VectorX& parameters) const;
};

}  // namespace balance
