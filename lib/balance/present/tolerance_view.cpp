#include "balance/present/tolerance_view.hpp"

#include <cmath>
#include <limits>

namespace balance {

const std::vector<NumberOpening>& openings_of(const ToleranceView& view) {
  static const std::vector<NumberOpening> none;
  if (view.report) return view.report->openings;
  return view.at_rest ? view.at_rest->openings : none;
}

const FigureDeviation* find_deviation(const ToleranceReport& report, const std::string& quantity, Figure figure) {
  for (const QuantityTolerance& one : report.quantities) {
    if (one.quantity != quantity) continue;
    switch (figure) {
      case Figure::peak: return &one.peak;
      case Figure::rms: return &one.rms;
      case Figure::mean: return &one.mean;
      case Figure::range: return &one.range;
    }
  }
  return nullptr;
}

double disagreement(const ToleranceReport& report, const SampledFigure& sampled) {
  const FigureDeviation* exact = find_deviation(report, sampled.quantity, sampled.figure);
  if (exact == nullptr || !(sampled.deviation_error > 0)) return std::numeric_limits<double>::quiet_NaN();
  return std::abs(sampled.deviation - exact->deviation) / sampled.deviation_error;
}

}  // namespace balance
