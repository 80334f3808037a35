#include "balance/foundation/numerics/cubic_spline.hpp"

#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <utility>

namespace balance::numerics {
namespace {

using Index = Eigen::Index;

/// Second derivatives at the knots. Continuity of the slope at knot i reads
/// h[i-1] m[i-1] + 2 (h[i-1] + h[i]) m[i] + h[i] m[i+1] = 6 (slope[i] − slope[i-1]), with two end conditions in
/// addition.
/// The system stays tridiagonal and diagonally dominant for both kinds of ends, so elimination needs no pivoting.
Samples solve_moments(const std::vector<double>& knots, const Samples& values, SplineEnd end) {
  const Index last = values.rows() - 1;
  Samples moments = Samples::Zero(values.rows(), values.cols());
  if (last < 2) return moments;  // two points: a straight line
  VectorX h(last), upper(last + 1), diagonal(last + 1);
  for (Index i = 0; i < last; ++i) h[i] = knots[static_cast<std::size_t>(i + 1)] - knots[static_cast<std::size_t>(i)];
  for (Index i = 1; i < last; ++i) {
    double lower = h[i - 1], scale = 1;
    diagonal[i] = 2 * (h[i - 1] + h[i]);
    upper[i] = h[i];
    if (end == SplineEnd::not_a_knot && i == 1) {  // m[0] eliminated, row scaled by h1 / (h0 + h1)
      scale = h[1] / (h[0] + h[1]);
      diagonal[i] = h[0] + 2 * h[1];
      upper[i] = h[1] - h[0];
    }
    if (end == SplineEnd::not_a_knot && i == last - 1) {  // m[last] eliminated likewise
      scale = h[i - 1] / (h[i - 1] + h[i]);
      diagonal[i] = 2 * h[i - 1] + h[i];
      lower = h[i - 1] - h[i];
    }
    moments.row(i) =
        6 * scale * ((values.row(i + 1) - values.row(i)) / h[i] - (values.row(i) - values.row(i - 1)) / h[i - 1]);
    if (i == 1) continue;
    const double factor = lower / diagonal[i - 1];
    diagonal[i] -= factor * upper[i - 1];
    moments.row(i) -= factor * moments.row(i - 1);
  }
  moments.row(last - 1) /= diagonal[last - 1];
  for (Index i = last - 2; i >= 1; --i) {
    moments.row(i) = (moments.row(i) - upper[i] * moments.row(i + 1)) / diagonal[i];
  }
  if (end == SplineEnd::not_a_knot) {
    moments.row(0) = moments.row(1) + (moments.row(1) - moments.row(2)) * (h[0] / h[1]);
    moments.row(last) =
        moments.row(last - 1) + (moments.row(last - 1) - moments.row(last - 2)) * (h[last - 1] / h[last - 2]);
  }
  return moments;
}

/// Second derivatives of a closed spline. The equations of the inner knots and of the seam are tridiagonal but for the
/// two corners, which a rank-one correction restores (Sherman and Morrison).
Samples solve_periodic_moments(const std::vector<double>& knots, const Samples& values) {
  const Index n = values.rows() - 1;  // distinct knots
  VectorX h(n), diagonal(n);
  for (Index i = 0; i < n; ++i) h[i] = knots[static_cast<std::size_t>(i + 1)] - knots[static_cast<std::size_t>(i)];
  const auto before = [n](Index i) { return i == 0 ? n - 1 : i - 1; };
  // columns: one right-hand side per component, then the correction's vector
  MatrixX solution(n, values.cols() + 1);
  for (Index i = 0; i < n; ++i) {
    diagonal[i] = 2 * (h[before(i)] + h[i]);
    solution.row(i).head(values.cols()) = 6 * ((values.row(i + 1) - values.row(i)) / h[i] -
                                               (values.row(before(i) + 1) - values.row(before(i))) / h[before(i)]);
  }
  const double corner = h[n - 1], shift = -diagonal[0];
  solution.col(values.cols()).setZero();
  solution(0, values.cols()) = shift;
  solution(n - 1, values.cols()) = corner;
  diagonal[0] -= shift;
  diagonal[n - 1] -= corner * corner / shift;
  for (Index i = 1; i < n; ++i) {
    const double factor = h[i - 1] / diagonal[i - 1];
    diagonal[i] -= factor * h[i - 1];
    solution.row(i) -= factor * solution.row(i - 1);
  }
  solution.row(n - 1) /= diagonal[n - 1];
  for (Index i = n - 2; i >= 0; --i) solution.row(i) = (solution.row(i) - h[i] * solution.row(i + 1)) / diagonal[i];
  const VectorX correction = solution.col(values.cols());
  const double ratio = corner / shift, scale = 1 + correction[0] + ratio * correction[n - 1];
  Samples moments(n + 1, values.cols());
  for (Index c = 0; c < values.cols(); ++c)
    moments.col(c).head(n) = solution.col(c) - (solution(0, c) + ratio * solution(n - 1, c)) / scale * correction;
  moments.row(n) = moments.row(0);
  return moments;
}

}  // namespace

Samples find_spline_second_derivatives(const std::vector<double>& knots, const Samples& values, SplineEnd end) {
  return end == SplineEnd::periodic ? solve_periodic_moments(knots, values) : solve_moments(knots, values, end);
}

CubicSpline::CubicSpline(std::vector<double> knots, Samples values, SplineEnd end)
    : knots_(std::move(knots)), values_(std::move(values)) {
  const std::size_t min_points = end == SplineEnd::natural ? 2 : 4;
  if (knots_.size() < min_points)
    throw std::invalid_argument("a spline needs at least " + std::to_string(min_points) + " points");
  if (static_cast<std::size_t>(values_.rows()) != knots_.size()) {
    throw std::invalid_argument("a spline needs one row of values per knot");
  }
  for (std::size_t i = 1; i < knots_.size(); ++i) {
    if (!(knots_[i] > knots_[i - 1])) throw std::invalid_argument("the knots of a spline must increase");
  }
  if (end == SplineEnd::periodic && values_.row(0) != values_.bottomRows<1>().row(0))
    throw std::invalid_argument("a closed spline must end where it starts");
  moments_ = find_spline_second_derivatives(knots_, values_, end);
}

void CubicSpline::at(double parameter, Eigen::Ref<VectorX> value, Eigen::Ref<VectorX> first,
                     Eigen::Ref<VectorX> second) const {
  const auto right_knot = std::upper_bound(knots_.begin() + 1, knots_.end() - 1, parameter);
  const auto right = static_cast<std::size_t>(right_knot - knots_.begin());
  const Index i = static_cast<Index>(right) - 1;
  const double h = knots_[right] - knots_[right - 1];
  const double b = (parameter - knots_[right - 1]) / h, a = 1 - b;
  const double value_left = (a * a - 1) * a * h * h / 6, value_right = (b * b - 1) * b * h * h / 6;
  const double first_left = (1 - 3 * a * a) * h / 6, first_right = (3 * b * b - 1) * h / 6;
  for (Index c = 0; c < values_.cols(); ++c) {
    const double x0 = values_(i, c), x1 = values_(i + 1, c), m0 = moments_(i, c), m1 = moments_(i + 1, c);
    value[c] = a * x0 + b * x1 + value_left * m0 + value_right * m1;
    first[c] = (x1 - x0) / h + first_left * m0 + first_right * m1;
    second[c] = a * m0 + b * m1;
  }
}

double CubicSpline::interval_length(double parameter) const {
  const auto right = std::upper_bound(knots_.begin() + 1, knots_.end() - 1, parameter);
  return *right - *(right - 1);
}

}  // namespace balance::numerics
