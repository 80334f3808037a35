#include "balance/synthesis/tolerance/robust_figure.hpp"

#include "balance/mechanics/results/quantities.hpp"
#include "balance/mechanics/results/run_quantities.hpp"
#include "balance/motion/simulation/run_figure.hpp"
#include "balance/synthesis/tolerance/toleranced_run.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

namespace balance::tolerance {

namespace {

constexpr double undefined_figure = std::numeric_limits<double>::quiet_NaN();

/// Values at one instant of a run.
struct RunSample {
  double weight = 0;  ///< fraction of the duration
  VectorX value;      ///< components of the series
  MatrixX change;     ///< numbers × components
  double variance() const { return change.squaredNorm(); }
  double expected_square() const { return value.squaredNorm() + variance(); }
};

class RobustSeriesEvaluator {
 public:
  RobustSeriesEvaluator(const TolerancedRun& toleranced_run, const Tolerances& numbers,
                        const results::MetricSeries& series)
      : numbers_(numbers) {
    for (const ToleranceSample& tolerance_sample : toleranced_run.samples())
      samples_.push_back({tolerance_sample.weight, toleranced_run.value(series, tolerance_sample),
                          toleranced_run.contributions(series, tolerance_sample)});
  }

  RobustFigure compute(Statistic figure, double k) const {
    switch (figure) {
      case Statistic::peak: return peak(k);
      case Statistic::rms: return rms(k);
      case Statistic::mean: return mean(k);
      case Statistic::range: return range(k);
      case Statistic::maximum: return maximum(k);
      case Statistic::minimum: break;  // not offered
    }
    return {};
  }

 private:
  RobustFigure peak(double k) const {
    RobustFigure result;
    result.value = -1;
    for (const RunSample& sample : samples_) {
      const double magnitude = sample.value.norm(), deviation = std::sqrt(sample.variance());
      result.nominal = std::max(result.nominal, magnitude);
      if (magnitude + k * deviation > result.value) {
        result.mean = magnitude;
        result.deviation = deviation;
        result.value = magnitude + k * deviation;
      }
    }
    return result;
  }

  RobustFigure maximum(double k) const {
    constexpr double lowest = -std::numeric_limits<double>::infinity();
    RobustFigure result{lowest, 0, 0, lowest};
    for (const RunSample& sample : samples_) {
      const ValueWithGradient one = magnitude_with_gradient(sample);
      result.nominal = std::max(result.nominal, one.value);
      const double deviation = one.change.norm();
      if (one.value + k * deviation > result.value)
        result = {result.nominal, one.value, deviation, one.value + k * deviation};
    }
    return result;
  }

  RobustFigure rms(double k) const {
    double nominal_square = 0, expected_square = 0;
    for (const RunSample& sample : samples_) {
      nominal_square += sample.weight * sample.value.squaredNorm();
      expected_square += sample.weight * sample.expected_square();
    }
    const double root = std::sqrt(expected_square);
    return root_figure(std::sqrt(nominal_square), root, k, [&](const RunSample&) { return root; });
  }

  RobustFigure mean(double k) const {
    double nominal = 0, expected_mean = 0;
    for (const RunSample& sample : samples_) {
      nominal += sample.weight * sample.value.norm();
      expected_mean += sample.weight * std::sqrt(sample.expected_square());
    }
    return root_figure(nominal, expected_mean, k,
                       [](const RunSample& sample) { return std::sqrt(sample.expected_square()); });
  }

  /// For Σ w √E with E the expected squares at each instant or over all of them. Squares q differ from their
  /// expectation by q − E = 2 bᵀ z + zᵀ G z − tr G, and their roots by (q − E) / (2 √E).
  template <class Root>
  RobustFigure root_figure(double nominal, double mean, double k, Root&& root) const {
    const auto size = static_cast<Eigen::Index>(numbers_.size());
    VectorX cross = VectorX::Zero(size);
    MatrixX squares = MatrixX::Zero(size, size);
    for (const RunSample& sample : samples_) {
      const double expected_root = root(sample);
      if (!(expected_root > 0)) continue;
      cross += sample.weight / expected_root * sample.change * sample.value;
      squares += sample.weight / expected_root * sample.change * sample.change.transpose();
    }
    double variance = cross.squaredNorm() + squares.squaredNorm() / 2;
    for (Eigen::Index i = 0; i < size; ++i)
      variance +=
          excess_kurtosis(numbers_[static_cast<std::size_t>(i)].distribution) * squares(i, i) * squares(i, i) / 4;
    const double deviation = std::sqrt(std::max(0.0, variance));
    return {nominal, mean, deviation, mean + k * deviation};
  }

  /// A scalar or a magnitude, and its derivatives times the deviations; zero derivatives if the magnitude is zero.
  struct ValueWithGradient {
    double value = 0;
    VectorX change;
  };

  static ValueWithGradient magnitude_with_gradient(const RunSample& sample) {
    if (sample.value.size() == 1) return {sample.value[0], sample.change.col(0)};
    const double magnitude = sample.value.norm();
    if (magnitude > 0) return {magnitude, sample.change * sample.value / magnitude};
    return {0, VectorX::Zero(sample.change.rows())};
  }

  /// The maximum over all pairs of instants. Pairs that even opposite deviations could not make larger are skipped.
  RobustFigure range(double k) const {
    std::vector<ValueWithGradient> signed_values;
    for (const RunSample& sample : samples_) signed_values.push_back(magnitude_with_gradient(sample));
    const auto sort_bounds = [&](double sign) {
      std::vector<std::pair<double, std::size_t>> bounds;
      for (std::size_t i = 0; i < signed_values.size(); ++i)
        bounds.emplace_back(sign * signed_values[i].value + k * signed_values[i].change.norm(), i);
      std::sort(bounds.begin(), bounds.end(), std::greater<>());
      return bounds;
    };
    const auto upper_bounds = sort_bounds(1), lower_bounds = sort_bounds(-1);
    const auto is_lower = [](const ValueWithGradient& a, const ValueWithGradient& b) { return a.value < b.value; };
    const auto [lowest, highest] = std::minmax_element(signed_values.begin(), signed_values.end(), is_lower);
    RobustFigure result{highest->value - lowest->value, 0, 0, -1};
    for (const auto& [upper, s] : upper_bounds) {
      if (upper + lower_bounds.front().first <= result.value) break;
      for (const auto& [lower, t] : lower_bounds) {
        if (upper + lower <= result.value) break;
        const double mean = signed_values[s].value - signed_values[t].value;
        const double deviation = (signed_values[s].change - signed_values[t].change).norm();
        if (mean + k * deviation > result.value) result = {result.nominal, mean, deviation, mean + k * deviation};
      }
    }
    return result;
  }

  const Tolerances& numbers_;
  std::vector<RunSample> samples_;
};

/// The worst of the series to which the quantity refers.
RobustFigure max_robust_figure(const TolerancedRun& toleranced_run, const Tolerances& numbers,
                               const ObjectiveTerm& term) {
  std::optional<RobustFigure> worst;
  double nominal = -std::numeric_limits<double>::infinity();
  std::vector<results::MetricSeries> all_series;
  for (const results::MetricSeries& series : list_metric_series(toleranced_run.run()))
    if (results::is_quantity_name(term.quantity, series.quantity) || series.quantity.starts_with(term.quantity + "["))
      all_series.push_back(series);
  if (all_series.empty())
    if (std::optional<results::MetricSeries> series = find_series(toleranced_run.run(), term.quantity))
      all_series.push_back(std::move(*series));
  for (const results::MetricSeries& series : all_series) {
    const RobustFigure figure =
        RobustSeriesEvaluator(toleranced_run, numbers, series).compute(term.figure, *term.deviation_multiple);
    nominal = std::max(nominal, figure.nominal);
    if (!worst || figure.value > worst->value) worst = figure;
  }
  if (!worst)
    throw std::invalid_argument("a run along '" + term.trajectory + "' has no quantity '" + term.quantity + "'");
  worst->nominal = nominal;
  return *worst;
}

}  // namespace

Tolerances evaluate_tolerances(const DesignSpace& space) {
  const study::RecordedValues<double> values(*space.recording, space.inputs);
  Tolerances numbers = space.start.tolerances;
  for (study::TolerancedParameter& number : numbers) {
    const double value = values(space.recording->toleranced.at(static_cast<std::size_t>(number.recording_index)));
    if (number.relative_width > 0) number.width = number.relative_width * std::abs(value);
    number.value = value;
  }
  return numbers;
}

RobustFigure compute_robust_figure(const DesignSpace& space, const VectorX& x, const ObjectiveTerm& term) {
  const DesignSpace fixed_space = space.fix_others(x, {});
  const Tolerances numbers = evaluate_tolerances(fixed_space);
  const study::DesignInstance instance{fixed_space.start.mechanism, fixed_space.start.trajectories};
  const TolerancedRun toleranced_run(fixed_space, numbers, simulation::find_trajectory(instance, term),
                                     {term.quantity});
  if (toleranced_run.outcome().status != MotionStatus::done)
    return {undefined_figure, undefined_figure, undefined_figure, undefined_figure};
  RobustFigure figure = max_robust_figure(toleranced_run, numbers, term);
  figure.incompatible_parameters = toleranced_run.incompatible_parameters();
  return figure;
}

std::vector<RobustTerm> robust_terms(const DesignSpace& space, const VectorX& x,
                                     const std::vector<ObjectiveTerm>& terms) {
  std::vector<RobustTerm> result;
  for (const ObjectiveTerm& term : terms)
    if (term.deviation_multiple) result.push_back({term, compute_robust_figure(space, x, term)});
  return result;
}

}  // namespace balance::tolerance
