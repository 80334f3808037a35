#include "balance/timing/series.hpp"

#include "balance/base/extrema.hpp"

#include <algorithm>
#include <cmath>

namespace balance {
namespace {

constexpr int series_terms = PiecewiseSeries::terms;
constexpr int first_panels = 8;    // over the whole parameter
constexpr int most_halvings = 14;  // a kink left in so short a panel does no harm
constexpr std::size_t most_panels = 4096;

bool has_ended(const Samples& terms, const VectorX& floor, double tolerance) {
  for (Eigen::Index c = 0; c < terms.cols(); ++c) {
    const double size = terms.col(c).cwiseAbs().sum();
    if (max_abs(terms.col(c).tail(3)) > std::max(tolerance * size, floor[c])) return false;
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
        parameters.push_back((w.begin + w.end) / 2 + (w.end - w.begin) / 2 * PiecewiseSeries::point(k));
    if (!sample(parameters, rows)) return FitStatus::not_sampled;
    std::vector<Waiting> next;
    for (std::size_t i = 0; i < waiting.size(); ++i) {
      const Waiting& w = waiting[i];
      Samples terms =
          PiecewiseSeries::transform() * rows.middleRows(static_cast<Eigen::Index>(i) * series_terms, series_terms);
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
