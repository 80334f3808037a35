#include "balance/present/tolerance_view.hpp"

#include <cmath>
#include <limits>

namespace balance {

const std::vector<IncompatibleParameter>& incompatible_parameters_of(const ToleranceReportData& view) {
  static const std::vector<IncompatibleParameter> none;
  if (view.report) return view.report->incompatible_parameters;
  return view.at_rest ? view.at_rest->incompatible_parameters : none;
}

const FigureDeviation* find_deviation(const ToleranceReport& report, const std::string& quantity, Statistic figure) {
  for (const QuantityTolerance& one : report.quantities) {
    if (one.quantity != quantity) continue;
    switch (figure) {
      case Statistic::peak: return &one.peak;
      case Statistic::rms: return &one.rms;
      case Statistic::mean: return &one.mean;
      case Statistic::range: return &one.range;
    }
  }
  return nullptr;
}

double sampling_disagreement(const ToleranceReport& report, const SampledFigure& sampled) {
  const FigureDeviation* exact = find_deviation(report, sampled.quantity, sampled.figure);
  if (exact == nullptr || !(sampled.deviation_error > 0)) return std::numeric_limits<double>::quiet_NaN();
  return std::abs(sampled.deviation - exact->deviation) / sampled.deviation_error;
}

}  // namespace balance
