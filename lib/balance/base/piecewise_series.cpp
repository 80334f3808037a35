#include "balance/base/piecewise_series.hpp"

#include "balance/base/elementary.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace balance {

std::size_t PiecewiseSeries::panel_at(double parameter, std::size_t first, std::size_t last) const {
  const auto begin = panels_.begin() + static_cast<std::ptrdiff_t>(first);
  const auto next = std::upper_bound(begin + 1, panels_.begin() + static_cast<std::ptrdiff_t>(last), parameter,
                                     [](double p, const Panel& panel) { return p < panel.begin; });
  return static_cast<std::size_t>(next - panels_.begin()) - 1;
}

void PiecewiseSeries::at(std::size_t panel, double parameter, double* out) const {
  const Panel& p = panels_[panel];
  const double x = (2 * parameter - p.begin - p.end) / (p.end - p.begin);
  const Eigen::Index columns = p.terms.cols();
  const double* term = p.terms.data();
  std::copy_n(term, columns, out);
  double last = 1, now = x;  // T_{j−1}, T_j
  for (int j = 1; j < terms; ++j) {
    term += columns;
    for (Eigen::Index c = 0; c < columns; ++c) out[c] += now * term[c];
    const double next = 2 * x * now - last;
    last = now;
    now = next;
  }
}

/// c'_{j−1} = c'_{j+1} + 2 j c_j on [−1, 1], the first one halved.
PiecewiseSeries PiecewiseSeries::derivative() const {
  std::vector<Panel> panels = panels_;
  for (Panel& panel : panels) {
    const Samples c = panel.terms * (2 / (panel.end - panel.begin));
    panel.terms.setZero();
    for (int j = terms - 1; j > 0; --j) {
      panel.terms.row(j - 1) = 2 * j * c.row(j);
      if (j + 1 < terms) panel.terms.row(j - 1) += panel.terms.row(j + 1);
    }
    panel.terms.row(0) /= 2;
  }
  return PiecewiseSeries(std::move(panels));
}

/// C_j = (c_{j−1} − c_{j+1}) / 2j on [−1, 1], where c_0 counts twice.
PiecewiseSeries PiecewiseSeries::integral() const {
  std::vector<Panel> panels = panels_;
  VectorX reached = VectorX::Zero(functions());
  for (Panel& panel : panels) {
    const Samples c = panel.terms * ((panel.end - panel.begin) / 2);
    panel.terms.row(0) = reached.transpose();
    for (int j = 1; j < terms; ++j) {
      panel.terms.row(j) = (j == 1 ? 2.0 : 1.0) * c.row(j - 1);
      if (j + 1 < terms) panel.terms.row(j) -= c.row(j + 1);
      panel.terms.row(j) /= 2 * j;
      panel.terms.row(0) += (j % 2 == 0 ? -1.0 : 1.0) * panel.terms.row(j);
    }
    reached = panel.terms.colwise().sum().transpose();
  }
  return PiecewiseSeries(std::move(panels));
}

double PiecewiseSeries::point(int k) { return -elementary::cos(std::numbers::pi * (2 * k + 1) / (2 * terms)); }

const PiecewiseSeries::Transform& PiecewiseSeries::transform() {
  static const Transform matrix = [] {
    Transform m;
    for (int j = 0; j < terms; ++j)
      for (int k = 0; k < terms; ++k)
        m(j, k) = (j == 0 ? 1.0 : 2.0) / terms * elementary::cos(j * elementary::acos(point(k)));
    return m;
  }();
  return matrix;
}

}  // namespace balance
