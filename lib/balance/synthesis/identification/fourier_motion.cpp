#include "balance/synthesis/identification/fourier_motion.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace balance::identification {

namespace {

/// Orthonormal vectors perpendicular to `normal`, in the order of its entries: the k-th has k + 2 of them that are not
/// zero, so that low harmonics come first.
MatrixX orthonormal_complement(const VectorX& normal) {
  const Eigen::Index n = normal.size();
  MatrixX complement = MatrixX::Zero(n, n - 1);
  for (Eigen::Index k = 0; k + 1 < n; ++k) {
    // normal.head(k + 1) scaled, and one entry that makes the product with the normal zero
    complement.col(k).head(k + 1) = normal.head(k + 1) * normal[k + 1];
    complement(k + 1, k) = -normal.head(k + 1).squaredNorm();
    complement.col(k).normalize();
  }
  return complement;
}

}  // namespace

FourierMotion::FourierMotion(int harmonics, double period) : period_(period) {
  if (harmonics < 2 || !(period > 0))
    throw std::invalid_argument("expected two harmonics or more and a positive period");
  const VectorX order = VectorX::LinSpaced(harmonics, 1, harmonics);
  sines_ = orthonormal_complement(VectorX::Ones(harmonics));
  cosines_ = orthonormal_complement(order);
}

VectorX FourierMotion::basis(double time, int order) const {
  const Eigen::Index H = sines_.rows();
  const double omega = 2 * std::numbers::pi / period_;
  VectorX sine(H), cosine(H);
  for (Eigen::Index k = 0; k < H; ++k) {
    const double multiple = static_cast<double>(k + 1), phase = multiple * omega * time;
    const double s = elementary::sin(phase), c = elementary::cos(phase);
    sine[k] = order == 0 ? s / multiple : order == 1 ? omega * c : -omega * omega * multiple * s;
    cosine[k] = order == 0 ? c / multiple : order == 1 ? -omega * s : -omega * omega * multiple * c;
  }
  VectorX values(coefficient_count());
  values << (order == 0 ? 1.0 : 0.0), sines_.transpose() * sine, cosines_.transpose() * cosine;
  return values;
}

MatrixX FourierMotion::basis(const VectorX& times, int order) const {
  MatrixX values(times.size(), coefficient_count());
  for (Eigen::Index k = 0; k < times.size(); ++k) values.row(k) = basis(times[k], order).transpose();
  return values;
}

MatrixX FourierMotion::series(const VectorX& u) const {
  const Eigen::Index free = sines_.cols();
  MatrixX factors(sines_.rows(), 2);
  factors.col(0) = sines_ * u.segment(1, free);
  factors.col(1) = cosines_ * u.tail(free);
  for (Eigen::Index k = 0; k < factors.rows(); ++k) factors.row(k) /= static_cast<double>(k + 1);
  return factors;
}

VectorX period_times(double period, Eigen::Index count) {
  VectorX times(count);
  for (Eigen::Index k = 0; k < count; ++k) times[k] = period * static_cast<double>(k) / static_cast<double>(count);
  return times;
}

}  // namespace balance::identification
