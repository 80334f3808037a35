#include "balance/cost/series.hpp"

#include <memory>
#include <stdexcept>

namespace balance {

/// L (parameters, 1).
VectorX Series::coordinates(const VectorX& parameters) const {
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

double of_coordinates(const Series& series, Figure figure, const VectorX& z, VectorX* slope) {
  switch (figure) {
    case Figure::peak: return series.samples->peak(z, slope);
    case Figure::mean: return series.samples->mean(z, slope);
    case Figure::range: return series.samples->range(z, slope);
    case Figure::rms: break;
  }
  return rms(z, slope);
}

}  // namespace

double Series::figure(Figure figure, const VectorX& parameters, VectorX* gradient) const {
  VectorX slope;
  const double value = of_coordinates(*this, figure, coordinates(parameters), gradient ? &slope : nullptr);
  if (!gradient) return value;
  const VectorX active = space.coordinates().transpose() * slope;
  gradient->setZero(parameters.size());
  for (Eigen::Index k = 0; k < active.size(); ++k) {
    const Eigen::Index column = space.active()[static_cast<std::size_t>(k)];
    if (column < gradient->size()) (*gradient)[column] = active[k];
  }
  return value;
}

CostFunction worst_of(Figure figure, std::vector<Series> series, Eigen::Index count) {
  const auto shared = std::make_shared<const std::vector<Series>>(std::move(series));
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
