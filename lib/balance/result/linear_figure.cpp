#include "balance/result/linear_figure.hpp"

#include "balance/base/extrema.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

double AffineFigure::operator()(const VectorX& parameters) const {
  if (coefficients.size() > 0) return coefficients.dot(parameters.head(coefficients.size()));
  double worst = 0;
  for (const AffineSeries& one : series) {
    const VectorX values = one.rows * parameters;
    const auto sizes = values.reshaped(one.components, one.time_weights.size()).colwise().norm();
    worst = std::max(worst, figure == Statistic::peak ? max_abs(sizes)
                                                      : std::sqrt(sizes.cwiseAbs2().dot(one.time_weights.transpose())));
  }
  return worst;
}

}  // namespace balance
