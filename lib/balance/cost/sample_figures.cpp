#include "balance/cost/sample_figures.hpp"

#include "balance/base/extrema.hpp"

namespace balance {

SampledFigures::SampledFigures(Eigen::Index places, Eigen::Index components, Eigen::Index coordinates)
    : places_(places), components_(components), matrices_(places * components, coordinates), weights_(places) {}

void SampledFigures::set_sample(Eigen::Index place, const MatrixX& matrix, double weight) {
  for (Eigen::Index c = 0; c < components_; ++c) matrices_.row(c * places_ + place) = matrix.row(c);
  weights_[place] = weight;
}

/// places × components.
MatrixX SampledFigures::values(const VectorX& z) const {
  MatrixX out(places_, components_);
  Eigen::Map<VectorX>(out.data(), out.size()).noalias() = matrices_ * z;
  return out;
}

/// Adds factor times the gradient of the magnitude at a place.
void SampledFigures::add_gradient(Eigen::Index place, const MatrixX& values, double factor, VectorX& gradient) const {
  const double magnitude = values.row(place).norm();
  if (magnitude == 0) return;
  for (Eigen::Index c = 0; c < components_; ++c)
    gradient += factor * values(place, c) / magnitude * matrices_.row(c * places_ + place).transpose();
}

double SampledFigures::peak(const VectorX& z, VectorX* gradient) const {
  const MatrixX all = values(z);
  const Eigen::Index place = max_index(all.rowwise().squaredNorm());
  const double peak = all.row(place).norm();
  if (gradient) {
    gradient->setZero(z.size());
    add_gradient(place, all, 1, *gradient);
  }
  return peak;
}

double SampledFigures::mean(const VectorX& z, VectorX* gradient) const {
  const MatrixX all = values(z);
  const VectorX magnitude = all.rowwise().norm();
  if (gradient) {
    const VectorX factor = (magnitude.array() > 0).select(weights_.array() / magnitude.array().max(1e-300), 0).matrix();
    gradient->setZero(z.size());
    for (Eigen::Index c = 0; c < components_; ++c)
      *gradient += matrices_.middleRows(c * places_, places_).transpose() * factor.cwiseProduct(all.col(c));
  }
  return weights_.dot(magnitude);
}

double SampledFigures::range(const VectorX& z, VectorX* gradient) const {
  const MatrixX all = values(z);
  const bool scalar = components_ == 1;
  const VectorX value = scalar ? VectorX(all.col(0)) : VectorX(all.rowwise().norm());
  const Eigen::Index low = min_index(value), high = max_index(value);
  const double range = value[high] - value[low];
  if (gradient) {
    gradient->setZero(z.size());
    if (scalar) {
      *gradient = (matrices_.row(high) - matrices_.row(low)).transpose();
    } else {
      add_gradient(high, all, 1, *gradient);
      add_gradient(low, all, -1, *gradient);
    }
  }
  return range;
}

}  // namespace balance
