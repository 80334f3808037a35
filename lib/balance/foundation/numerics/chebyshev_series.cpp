#include "balance/foundation/numerics/chebyshev_series.hpp"

#include "balance/foundation/base/elementary.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace balance::numerics {

/// C_j = (c_{j−1} − c_{j+1}) / 2j on [−1, 1], where c_0 counts twice.
Panel integrate(const Panel& panel) {
  constexpr int terms = PiecewiseChebyshevSeries::coefficient_count;
  const Samples c = panel.coefficients * ((panel.end - panel.begin) / 2);
  Panel integral{panel.begin, panel.end, Samples::Zero(terms, c.cols())};
  for (int j = 1; j < terms; ++j) {
    integral.coefficients.row(j) = (j == 1 ? 2.0 : 1.0) * c.row(j - 1);
    if (j + 1 < terms) integral.coefficients.row(j) -= c.row(j + 1);
    integral.coefficients.row(j) /= 2 * j;
    integral.coefficients.row(0) += (j % 2 == 0 ? -1.0 : 1.0) * integral.coefficients.row(j);
  }
  return integral;
}

Samples values_at_chebyshev_points(const Panel& panel) {
  const PiecewiseChebyshevSeries series({Panel{-1, 1, panel.coefficients}});
  Samples values(PiecewiseChebyshevSeries::coefficient_count, panel.coefficients.cols());
  for (int k = 0; k < values.rows(); ++k)
    series.evaluate(0, PiecewiseChebyshevSeries::chebyshev_point(k), &values(k, 0));
  return values;
}

std::size_t PiecewiseChebyshevSeries::find_panel(double parameter, std::size_t first, std::size_t last) const {
  const auto begin = panels_.begin() + static_cast<std::ptrdiff_t>(first);
  const auto next = std::upper_bound(begin + 1, panels_.begin() + static_cast<std::ptrdiff_t>(last), parameter,
                                     [](double p, const Panel& panel) { return p < panel.begin; });
  return static_cast<std::size_t>(next - panels_.begin()) - 1;
}

void PiecewiseChebyshevSeries::evaluate(std::size_t panel, double parameter, double* out) const {
  const Panel& p = panels_[panel];
  const double x = (2 * parameter - p.begin - p.end) / (p.end - p.begin);
  const Eigen::Index columns = p.coefficients.cols();
  const double* term = p.coefficients.data();
  std::copy_n(term, columns, out);
  double previous = 1, current = x;  // T_{j−1}, T_j
  for (int j = 1; j < coefficient_count; ++j) {
    term += columns;
    for (Eigen::Index c = 0; c < columns; ++c) out[c] += current * term[c];
    const double next = 2 * x * current - previous;
    previous = current;
    current = next;
  }
}

/// c'_{j−1} = c'_{j+1} + 2 j c_j on [−1, 1], the first one halved.
PiecewiseChebyshevSeries PiecewiseChebyshevSeries::derivative() const {
  std::vector<Panel> panels = panels_;
  for (Panel& panel : panels) {
    const Samples c = panel.coefficients * (2 / (panel.end - panel.begin));
    panel.coefficients.setZero();
    for (int j = coefficient_count - 1; j > 0; --j) {
      panel.coefficients.row(j - 1) = 2 * j * c.row(j);
      if (j + 1 < coefficient_count) panel.coefficients.row(j - 1) += panel.coefficients.row(j + 1);
    }
    panel.coefficients.row(0) /= 2;
  }
  return PiecewiseChebyshevSeries(std::move(panels));
}

PiecewiseChebyshevSeries PiecewiseChebyshevSeries::integral() const {
  std::vector<Panel> panels;
  VectorX begin_values = VectorX::Zero(function_count());
  for (const Panel& panel : panels_) {
    panels.push_back(integrate(panel));
    panels.back().coefficients.row(0) += begin_values.transpose();
    begin_values = panels.back().coefficients.colwise().sum().transpose();
  }
  return PiecewiseChebyshevSeries(std::move(panels));
}

double PiecewiseChebyshevSeries::chebyshev_point(int k) {
  return -elementary::cos(std::numbers::pi * (2 * k + 1) / (2 * coefficient_count));
}

const PiecewiseChebyshevSeries::Transform& PiecewiseChebyshevSeries::values_to_coefficients() {
  static const Transform matrix = [] {
    Transform m;
    for (int j = 0; j < coefficient_count; ++j)
      for (int k = 0; k < coefficient_count; ++k)
        m(j, k) = (j == 0 ? 1.0 : 2.0) / coefficient_count * elementary::cos(j * elementary::acos(chebyshev_point(k)));
    return m;
  }();
  return matrix;
}

}  // namespace balance::numerics
