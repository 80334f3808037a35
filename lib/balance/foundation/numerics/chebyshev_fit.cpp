#include "balance/foundation/numerics/chebyshev_fit.hpp"

#include "balance/foundation/numerics/extrema.hpp"

#include <algorithm>
#include <cmath>

namespace balance::numerics {
namespace {

constexpr int series_terms = PiecewiseChebyshevSeries::coefficient_count;
constexpr int min_series_panels = 8;  // per unit of the parameter
constexpr int max_bisections = 14;    // a kink in so short a panel is harmless
constexpr std::size_t max_panels = 4096;

bool has_converged(const Samples& terms, const VectorX& floor, double tolerance) {
  for (Eigen::Index c = 0; c < terms.cols(); ++c) {
    const double magnitude = terms.col(c).cwiseAbs().sum();
    if (max_abs(terms.col(c).tail(3)) > std::max(tolerance * magnitude, floor[c])) return false;
  }
  return true;
}

struct PendingPanel {
  double begin, end;
  int halvings;
};

std::vector<PendingPanel> make_initial_panels(const std::vector<double>& breakpoints) {
  std::vector<PendingPanel> panels;
  for (std::size_t i = 0; i + 1 < breakpoints.size(); ++i) {
    const double width = breakpoints[i + 1] - breakpoints[i];
    const int panel_count = std::max(1, static_cast<int>(std::ceil(min_series_panels * width - 1e-9)));
    for (int k = 0; k < panel_count; ++k)
      panels.push_back({breakpoints[i] + width * k / panel_count,
                        k + 1 == panel_count ? breakpoints[i + 1] : breakpoints[i] + width * (k + 1) / panel_count, 0});
  }
  return panels;
}

}  // namespace

FitStatus fit_chebyshev_series(const std::vector<double>& breakpoints, const VectorX& floor,
                               const FunctionSampler& sample, PiecewiseChebyshevSeries& series) {
  std::vector<PendingPanel> pending = make_initial_panels(breakpoints);
  std::vector<Panel> panels;
  Samples rows;
  while (!pending.empty()) {
    if (panels.size() + pending.size() > max_panels) return FitStatus::not_resolved;
    std::vector<double> parameters;
    for (const PendingPanel& panel : pending)
      for (int k = 0; k < series_terms; ++k)
        parameters.push_back((panel.begin + panel.end) / 2 +
                             (panel.end - panel.begin) / 2 * PiecewiseChebyshevSeries::chebyshev_point(k));
    if (!sample(parameters, rows)) return FitStatus::not_sampled;
    std::vector<PendingPanel> next;
    for (std::size_t i = 0; i < pending.size(); ++i) {
      const PendingPanel& panel = pending[i];
      Samples terms = PiecewiseChebyshevSeries::values_to_coefficients() *
                      rows.middleRows(static_cast<Eigen::Index>(i) * series_terms, series_terms);
      if (panel.halvings == max_bisections || has_converged(terms, floor, series_tolerance)) {
        panels.push_back({panel.begin, panel.end, std::move(terms)});
        continue;
      }
      const double middle = (panel.begin + panel.end) / 2;
      next.push_back({panel.begin, middle, panel.halvings + 1});
      next.push_back({middle, panel.end, panel.halvings + 1});
    }
    pending = std::move(next);
  }
  std::sort(panels.begin(), panels.end(), [](const Panel& a, const Panel& b) { return a.begin < b.begin; });
  series = PiecewiseChebyshevSeries(std::move(panels));
  return FitStatus::done;
}

}  // namespace balance::numerics
