#include "balance/compare/interpolant.hpp"

#include <algorithm>
#include <cmath>

namespace balance {
namespace {

constexpr double jump_slope_ratio = 10;  // than its neighbours: smooth samples that are worth comparing never come near
constexpr double sample_time_tolerance = 1e-9;  // of the whole time
constexpr double jump_epsilon = 1e-9;           // of the largest sample: steps of round-off are no jumps
constexpr Eigen::Index stencil_size = 4;        // samples that a value between is made of

}  // namespace

SampleInterpolant::SampleInterpolant(VectorX time, const Samples& samples, int first, int count)
    : time_(std::move(time)), samples_(samples), first_(first), count_(count) {
  find_jumps();
}

VectorX SampleInterpolant::row(Eigen::Index k) const { return samples_.row(k).segment(first_, count_).transpose(); }

void SampleInterpolant::find_jumps() {
  const Eigen::Index n = time_.size();
  VectorX step(std::max<Eigen::Index>(n, 1)), slope(step.size());
  step[0] = slope[0] = 0;
  double largest = 0;
  for (Eigen::Index k = 0; k < n; ++k) largest = std::max(largest, row(k).norm());
  for (Eigen::Index k = 1; k < n; ++k) {
    step[k] = (row(k) - row(k - 1)).norm();
    slope[k] = step[k] / (time_[k] - time_[k - 1]);
  }
  piece_begins_ = {0};
  for (Eigen::Index k = 1; k < n; ++k) {
    // Two steps beside it; one alone may happen to be flat.
    const Eigen::Index from = std::clamp<Eigen::Index>(k - 1, 1, std::max<Eigen::Index>(n - 3, 1));
    double beside = 0;
    for (Eigen::Index i = from; i < std::min(from + 3, n); ++i) beside = i == k ? beside : std::max(beside, slope[i]);
    if (n > 3 && step[k] > jump_epsilon * largest && slope[k] > jump_slope_ratio * beside) piece_begins_.push_back(k);
  }
  piece_begins_.push_back(n);
}

std::optional<VectorX> SampleInterpolant::evaluate(double time) const {
  const Eigen::Index n = time_.size();
  if (n == 0) return std::nullopt;
  const double tolerance = sample_time_tolerance * (time_[n - 1] - time_[0]);
  const auto later = std::lower_bound(time_.begin(), time_.end(), time - tolerance);
  const Eigen::Index k = later - time_.begin();
  if (k == n) return std::nullopt;
  if (std::abs(time_[k] - time) <= tolerance) return row(k);
  if (k == 0) return std::nullopt;
  const auto end = std::upper_bound(piece_begins_.begin(), piece_begins_.end(), k - 1);
  if (*end == k) return std::nullopt;  // a piece begins with the later of the two
  const Eigen::Index points = std::min(stencil_size, *end - *(end - 1));
  const Eigen::Index from = std::clamp(k - points / 2, *(end - 1), *end - points);
  VectorX value = VectorX::Zero(count_);
  for (Eigen::Index i = from; i < from + points; ++i) {
    double weight = 1;  // of Lagrange
    for (Eigen::Index j = from; j < from + points; ++j) {
      if (j != i) weight *= (time - time_[j]) / (time_[i] - time_[j]);
    }
    value += weight * row(i);
  }
  return value;
}

}  // namespace balance
