#include "balance/result/linear_figure.hpp"

#include "balance/base/extrema.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

double LinearFigure::operator()(const VectorX& parameters) const {
  if (coefficients.size() > 0) return coefficients.dot(parameters.head(coefficients.size()));
  double worst = 0;
  for (const PlaceRows& one : series) {
    const VectorX values = one.rows * parameters;
    const auto sizes = values.reshaped(one.components, one.share.size()).colwise().norm();
    worst = std::max(worst,
                     figure == Figure::peak ? max_abs(sizes) : std::sqrt(sizes.cwiseAbs2().dot(one.share.transpose())));
  }
  return worst;
}

}  // namespace balance
