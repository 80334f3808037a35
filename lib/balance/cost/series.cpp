#include "balance/cost/series.hpp"

#include <memory>
#include <stdexcept>

namespace balance {

/// L (parameters, 1).
VectorX CostSeries::coordinates(const VectorX& parameters) const {
  const std::vector<Eigen::Index>& active = space.active();
  VectorX x(static_cast<Eigen::Index>(active.size()));
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    const Eigen::Index column = active[static_cast<std::size_t>(k)];
    x[k] = column < parameters.size() ? parameters[column] : 1;
  }
  return space.coordinates() * x;
}

namespace {

double rms(const VectorX& z, VectorX* slope) {
  const double rms = z.norm();
  if (slope) *slope = rms > 0 ? VectorX(z / rms) : VectorX(VectorX::Zero(z.size()));
  return rms;
}

double figure_of_coordinates(const CostSeries& series, Statistic figure, const VectorX& z, VectorX* slope) {
  switch (figure) {
    case Statistic::peak: return series.samples->peak(z, slope);
    case Statistic::mean: return series.samples->mean(z, slope);
    case Statistic::range: return series.samples->range(z, slope);
    case Statistic::rms: break;
  }
  return rms(z, slope);
}

}  // namespace

double CostSeries::figure(Statistic figure, const VectorX& parameters, VectorX* gradient) const {
  VectorX slope;
  const double value = figure_of_coordinates(*this, figure, coordinates(parameters), gradient ? &slope : nullptr);
  if (!gradient) return value;
  const VectorX active = space.coordinates().transpose() * slope;
  gradient->setZero(parameters.size());
  for (Eigen::Index k = 0; k < active.size(); ++k) {
    const Eigen::Index column = space.active()[static_cast<std::size_t>(k)];
    if (column < gradient->size()) (*gradient)[column] = active[k];
  }
  return value;
}

CostFunction make_max_cost(Statistic figure, std::vector<CostSeries> series, Eigen::Index count) {
  const auto shared = std::make_shared<const std::vector<CostSeries>>(std::move(series));
  return [shared, figure, count](const VectorX& parameters, VectorX* gradient) {
    if (parameters.size() != count) throw std::invalid_argument("not as many values as there are parameters");
    double worst = shared->front().figure(figure, parameters, gradient);
    VectorX other;
    for (std::size_t s = 1; s < shared->size(); ++s) {
      const double value = (*shared)[s].figure(figure, parameters, gradient ? &other : nullptr);
      if (value <= worst) continue;
      worst = value;
      if (gradient) gradient->swap(other);
    }
    return worst;
  };
}

}  // namespace balance
