#include "balance/timing/series.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace balance {
namespace {

constexpr int series_terms = PiecewiseSeries::terms;
constexpr int first_panels = 8;    // over the whole parameter
constexpr int most_halvings = 14;  // a kink left in so short a panel does no harm
constexpr std::size_t most_panels = 4096;

/// Chebyshev's points of the first kind, increasing: the ends, where functions may jump, are none of them.
double series_point(int k) { return -std::cos(std::numbers::pi * (2 * k + 1) / (2 * series_terms)); }

/// From values at the points to terms.
const Eigen::Matrix<double, series_terms, series_terms>& transform() {
  static const Eigen::Matrix<double, series_terms, series_terms> matrix = [] {
    Eigen::Matrix<double, series_terms, series_terms> m;
    for (int j = 0; j < series_terms; ++j)
      for (int k = 0; k < series_terms; ++k)
        m(j, k) = (j == 0 ? 1.0 : 2.0) / series_terms * std::cos(j * std::acos(series_point(k)));
    return m;
  }();
  return matrix;
}

bool has_ended(const Samples& terms, const VectorX& floor, double tolerance) {
  for (Eigen::Index c = 0; c < terms.cols(); ++c) {
    const double size = terms.col(c).cwiseAbs().sum();
    if (terms.col(c).tail(3).cwiseAbs().maxCoeff() > std::max(tolerance * size, floor[c])) return false;
  }
  return true;
}

struct Waiting {
  double begin, end;
  int halvings;
};

std::vector<Waiting> first_stretches(const std::vector<double>& stations) {
  std::vector<Waiting> stretches;
  for (std::size_t i = 0; i + 1 < stations.size(); ++i) {
    const double width = stations[i + 1] - stations[i];
    const int pieces = std::max(1, static_cast<int>(std::ceil(first_panels * width - 1e-9)));
    for (int k = 0; k < pieces; ++k)
      stretches.push_back({stations[i] + width * k / pieces,
                           k + 1 == pieces ? stations[i + 1] : stations[i] + width * (k + 1) / pieces, 0});
  }
  return stretches;
}

}  // namespace

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
  for (int j = 1; j < series_terms; ++j) {
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
    for (int j = series_terms - 1; j > 0; --j) {
      panel.terms.row(j - 1) = 2 * j * c.row(j);
      if (j + 1 < series_terms) panel.terms.row(j - 1) += panel.terms.row(j + 1);
    }
    panel.terms.row(0) /= 2;
  }
  return PiecewiseSeries(std::move(panels));
}

FitStatus fit_series(const std::vector<double>& stations, const VectorX& floor, const SampleFunctions& sample,
                     PiecewiseSeries& series) {
  std::vector<Waiting> waiting = first_stretches(stations);
  std::vector<Panel> panels;
  Samples rows;
  while (!waiting.empty()) {
    if (panels.size() + waiting.size() > most_panels) return FitStatus::too_rough;
    std::vector<double> parameters;
    for (const Waiting& w : waiting)
      for (int k = 0; k < series_terms; ++k)
        parameters.push_back((w.begin + w.end) / 2 + (w.end - w.begin) / 2 * series_point(k));
    if (!sample(parameters, rows)) return FitStatus::not_sampled;
    std::vector<Waiting> next;
    for (std::size_t i = 0; i < waiting.size(); ++i) {
      const Waiting& w = waiting[i];
      Samples terms = transform() * rows.middleRows(static_cast<Eigen::Index>(i) * series_terms, series_terms);
      if (w.halvings == most_halvings || has_ended(terms, floor, series_tolerance)) {
        panels.push_back({w.begin, w.end, std::move(terms)});
        continue;
      }
      const double middle = (w.begin + w.end) / 2;
      next.push_back({w.begin, middle, w.halvings + 1});
      next.push_back({middle, w.end, w.halvings + 1});
    }
    waiting = std::move(next);
  }
  std::sort(panels.begin(), panels.end(), [](const Panel& a, const Panel& b) { return a.begin < b.begin; });
  series = PiecewiseSeries(std::move(panels));
  return FitStatus::done;
}

}  // namespace balance
