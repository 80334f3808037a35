#include "balance/foundation/numerics/chebyshev_fit.hpp"

#include "balance/foundation/numerics/extrema.hpp"

#include <algorithm>
#include <cmath>

namespace balance {
namespace {

constexpr int series_terms = PiecewiseChebyshevSeries::coefficient_count;
constexpr int min_series_panels = 8;  // over the whole parameter
constexpr int max_bisections = 14;    // a kink left in so short a panel does no harm
constexpr std::size_t max_panels = 4096;

bool has_converged(const Samples& terms, const VectorX& floor, double tolerance) {
  for (Eigen::Index c = 0; c < terms.cols(); ++c) {
    const double size = terms.col(c).cwiseAbs().sum();
    if (max_abs(terms.col(c).tail(3)) > std::max(tolerance * size, floor[c])) return false;
  }
  return true;
}

struct PendingPanel {
  double begin, end;
  int halvings;
};

std::vector<PendingPanel> make_initial_panels(const std::vector<double>& stations) {
  std::vector<PendingPanel> stretches;
  for (std::size_t i = 0; i + 1 < stations.size(); ++i) {
    const double width = stations[i + 1] - stations[i];
    const int pieces = std::max(1, static_cast<int>(std::ceil(min_series_panels * width - 1e-9)));
    for (int k = 0; k < pieces; ++k)
      stretches.push_back({stations[i] + width * k / pieces,
                           k + 1 == pieces ? stations[i + 1] : stations[i] + width * (k + 1) / pieces, 0});
  }
  return stretches;
}

}  // namespace

FitStatus fit_chebyshev_series(const std::vector<double>& stations, const VectorX& floor, const FunctionSampler& sample,
                               PiecewiseChebyshevSeries& series) {
  std::vector<PendingPanel> waiting = make_initial_panels(stations);
  std::vector<Panel> panels;
  Samples rows;
  while (!waiting.empty()) {
    if (panels.size() + waiting.size() > max_panels) return FitStatus::not_resolved;
    std::vector<double> parameters;
    for (const PendingPanel& w : waiting)
      for (int k = 0; k < series_terms; ++k)
        parameters.push_back((w.begin + w.end) / 2 +
                             (w.end - w.begin) / 2 * PiecewiseChebyshevSeries::chebyshev_point(k));
    if (!sample(parameters, rows)) return FitStatus::not_sampled;
    std::vector<PendingPanel> next;
    for (std::size_t i = 0; i < waiting.size(); ++i) {
      const PendingPanel& w = waiting[i];
      Samples terms = PiecewiseChebyshevSeries::values_to_coefficients() *
                      rows.middleRows(static_cast<Eigen::Index>(i) * series_terms, series_terms);
      if (w.halvings == max_bisections || has_converged(terms, floor, series_tolerance)) {
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
  series = PiecewiseChebyshevSeries(std::move(panels));
  return FitStatus::done;
}

}  // namespace balance
