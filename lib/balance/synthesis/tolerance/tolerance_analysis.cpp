#include "balance/synthesis/tolerance/tolerance_analysis.hpp"

#include "balance/mechanics/results/quantities.hpp"
#include "balance/mechanics/results/round_off.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/synthesis/tolerance/extreme_figure.hpp"
#include "balance/synthesis/tolerance/toleranced_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

namespace balance::tolerance {

using derivatives::FigureGradient;

void add_incompatible_parameters(const derivatives::ClosureGaps& gaps, std::size_t number, const std::string& path,
                                 double deviation, const Mechanism& mechanism,
                                 std::vector<IncompatibleParameter>& incompatible_parameters) {
  if (deviation == 0) return;
  for (const derivatives::ClosureGap& gap : gaps)
    incompatible_parameters.push_back({number, path, mechanism.joints[static_cast<std::size_t>(gap.joint)].name,
                                       gap.is_length ? "m" : "rad", gap.gap * deviation});
}

Tolerances remove_incompatible_parameters(const Tolerances& numbers,
                                          const std::vector<IncompatibleParameter>& incompatible_parameters) {
  Tolerances compatible;
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if (std::none_of(incompatible_parameters.begin(), incompatible_parameters.end(),
                     [i](const IncompatibleParameter& parameter) { return parameter.index == i; }))
      compatible.push_back(numbers[i]);
  if (compatible.empty()) throw std::invalid_argument("every number opens a joint, so there is nothing to draw");
  return compatible;
}

std::string format_incompatibility_note(const IncompatibleParameter& parameter) {
  return fmt::format(
      "over-constrained loops cannot follow {} by itself: its deviation would open {} by {:.3g} {} and is not included "
      "in the results",
      parameter.key_path, parameter.joint, parameter.gap, parameter.unit);
}

namespace {

/// A magnitude below this multiple of its deviation is not considered linear in the numbers.
constexpr double min_linear_ratio = 3;
/// Other instants are ignored if they change a deviation by at most this fraction.
constexpr double extreme_deviation_tolerance = 0.02;
constexpr double undefined_deviation = std::numeric_limits<double>::quiet_NaN();

class ToleranceAnalysis {
 public:
  ToleranceAnalysis(const DesignSpace& space, const Tolerances& numbers, const Trajectory& trajectory,
                    const std::vector<std::string>& quantities)
      : numbers_(numbers),
        nominal_(simulate(space.start.mechanism, trajectory)),
        toleranced_run_(space, numbers, trajectory, quantities) {}

  ToleranceReport report(const std::vector<std::string>& quantities) const {
    ToleranceReport result;
    result.outcome = nominal_.outcome;
    result.numbers = numbers_;
    result.run = nominal_;
    if (nominal_.outcome.status == MotionStatus::done) result.outcome = run().outcome;
    if (result.outcome.status != MotionStatus::done) return result;
    result.incompatible_parameters = toleranced_run_.incompatible_parameters();
    result.deviation = deviations();
    const std::vector<results::MetricSeries> all_series = list_metric_series(run());
    std::vector<results::MetricSeries> requested_series;
    for (std::size_t t = 0; t < all_series.size(); ++t) {
      if (!is_requested(all_series[t], quantities)) continue;
      requested_series.push_back(all_series[t]);
      result.quantities.push_back(analyse_quantity(all_series[t], t));
    }
    apply_extreme_statistics(requested_series, result.quantities);
    for (QuantityTolerance& quantity : result.quantities) drop_round_off(quantity);
    result.energy = figure([](const derivatives::FigureGradients& gradients) { return gradients.energy; },
                           [](const derivatives::FigureGradients& gradients) { return gradients.d_energy; });
    drop_round_off(result.energy);
    return result;
  }

 private:
  Eigen::Index size() const { return toleranced_run_.deviations().size(); }
  const RunResult& run() const { return toleranced_run_.run(); }

  static bool is_requested(const results::MetricSeries& series, const std::vector<std::string>& quantities) {
    return quantities.empty() || std::any_of(quantities.begin(), quantities.end(), [&](const std::string& name) {
             return results::is_quantity_or_array_name(name, series.quantity);
           });
  }

  /// The standard deviation of every entry.
  RunResult deviations() const {
    RunResult result = run();
    for (const results::QuantityDefinition& kind : results::quantity_table()) {
      Samples& array = result.*kind.member;
      if (array.size() == 0) continue;
      array.setZero();
      for (Eigen::Index i = 0; i < size(); ++i) {
        const Samples& change = toleranced_run_.derivative(i, false).*kind.member;
        if (change.rows() == array.rows() && change.cols() == array.cols())
          array.array() += (toleranced_run_.deviations()[i] * change.array()).square();
      }
      array = array.cwiseSqrt();
      for (Eigen::Index c = 0; c < array.cols(); ++c)
        results::clear_column(array, c, column_round_off(nominal_, kind.member, c));
    }
    return result;
  }

  template <class Value, class Derivative>
  FigureDeviation figure(Value&& value, Derivative&& derivative) const {
    FigureDeviation result{value(toleranced_run_.figures().front()), 0, VectorX(size())};
    for (Eigen::Index i = 0; i < size(); ++i) {
      const std::size_t k = static_cast<std::size_t>(i);
      result.contributions[i] =
          derivative(toleranced_run_.figures()[k / numerics::dual_width])[k % numerics::dual_width] *
          toleranced_run_.deviations()[i];
    }
    result.deviation = result.contributions.norm();
    return result;
  }

  void blank_incompatible_parameters(VectorX& by_number) const {
    for (const IncompatibleParameter& parameter : toleranced_run_.incompatible_parameters())
      by_number[static_cast<Eigen::Index>(parameter.index)] = undefined_deviation;
  }

  /// Peaks and ranges that may occur at other instants.
  void apply_extreme_statistics(const std::vector<results::MetricSeries>& requested_series,
                                std::vector<QuantityTolerance>& quantities) const {
    struct ExtremeFigureTask {
      FigureDeviation* figure;
      ExtremeFigure extreme;
    };
    std::vector<ExtremeFigureTask> extreme_tasks;
    for (std::size_t t = 0; t < requested_series.size(); ++t) {
      results::MetricSeries series = requested_series[t];
      if (series.array == &RunResult::total_torque) {  // a magnitude, not linear near zero
        series.array = &RunResult::torque;
        series.first = 0, series.count = static_cast<int>(run().torque.cols());
      }
      std::vector<LinearizedSample> samples;
      for (const ToleranceSample& sample : toleranced_run_.samples())
        samples.push_back(
            {sample.time, toleranced_run_.value(series, sample), toleranced_run_.contributions(series, sample)});
      using enum ExtremeFigure::Kind;
      for (const auto& [figure, kind] : {std::pair{&quantities[t].peak, peak}, {&quantities[t].range, range}}) {
        if (std::isnan(figure->deviation)) continue;
        ExtremeFigure extreme(samples, kind);
        if (extreme.has_several_candidates()) extreme_tasks.push_back({figure, std::move(extreme)});
      }
    }
    std::vector<ExtremeFigure*> extremes;
    for (ExtremeFigureTask& task : extreme_tasks) extremes.push_back(&task.extreme);
    sample_extreme_figures(extremes, numbers_);
    for (const auto& [figure, extreme] : extreme_tasks) {
      const double deviation = extreme.deviation();
      if (std::abs(deviation - figure->deviation) <= extreme_deviation_tolerance * figure->deviation) continue;
      figure->deviation = deviation;
      figure->contributions = extreme.contributions();
      figure->extremum_times = extreme.extremum_times();
    }
  }

  FigureDeviation figure_of_series(std::size_t t, double FigureGradient::*value,
                                   std::array<double, numerics::dual_width> FigureGradient::*derivative) const {
    return figure([&](const derivatives::FigureGradients& gradients) { return gradients.figures[t].*value; },
                  [&](const derivatives::FigureGradients& gradients) { return gradients.figures[t].*derivative; });
  }

  QuantityTolerance analyse_quantity(const results::MetricSeries& series, std::size_t t) const {
    QuantityTolerance result{.quantity = series.quantity, .unit = series.unit};
    result.peak = figure_of_series(t, &FigureGradient::peak, &FigureGradient::d_peak);
    result.rms = figure_of_series(t, &FigureGradient::rms, &FigureGradient::d_rms);
    result.mean = figure_of_series(t, &FigureGradient::mean, &FigureGradient::d_mean);
    result.range = figure_of_series(t, &FigureGradient::range, &FigureGradient::d_range);
    MatrixX squares = MatrixX::Zero(size(), size());
    VectorX cross = VectorX::Zero(size());
    double nominal_square = 0;
    for (const ToleranceSample& sample : toleranced_run_.samples()) {
      const VectorX value = toleranced_run_.value(series, sample);
      const MatrixX sensitivity = toleranced_run_.contributions(series, sample);
      squares += sample.weight * sensitivity * sensitivity.transpose();
      cross += sample.weight * sensitivity * value;
      nominal_square += sample.weight * value.squaredNorm();
      if (!sample.is_intermediate) update_worst(sample, value.norm(), sensitivity, result.worst);
    }
    finish(squares, cross, nominal_square, result);
    return result;
  }

  static void update_worst(const ToleranceSample& sample, double value, const MatrixX& sensitivity,
                           WorstSample& worst) {
    const VectorX variances = sensitivity.rowwise().squaredNorm();
    const double deviation = std::sqrt(variances.sum());
    if (worst.shares.size() > 0 && !(deviation > worst.deviation)) return;
    worst = {sample.row, sample.time, value, deviation,
             deviation > 0 ? VectorX(variances / variances.sum()) : variances};
  }

  void finish(const MatrixX& squares, const VectorX& cross, double nominal_square, QuantityTolerance& result) const {
    const double rms_deviation = std::sqrt(squares.trace());
    double variance = 4 * cross.squaredNorm() + 2 * squares.squaredNorm();
    for (std::size_t i = 0; i < numbers_.size(); ++i) {
      const double diagonal = squares(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i));
      variance += excess_kurtosis(numbers_[i].distribution) * diagonal * diagonal;
    }
    result.expected_rms = std::sqrt(nominal_square + rms_deviation * rms_deviation);
    result.square_deviation = std::sqrt(std::max(0.0, variance));
    if (rms_deviation > 0 && std::sqrt(nominal_square) < min_linear_ratio * rms_deviation)
      for (FigureDeviation* figure : {&result.peak, &result.rms, &result.mean}) figure->deviation = undefined_deviation;
    if (result.worst.deviation > 0 && result.range.value < min_linear_ratio * result.worst.deviation)
      result.range.deviation = undefined_deviation;
  }

  /// As in a run's metrics: a value below the round-off of its quantity becomes zero.
  void drop_round_off(QuantityTolerance& result) const {
    const auto& metrics = nominal_.metrics;
    const auto is_same_quantity = [&](const Metric& candidate) { return candidate.quantity == result.quantity; };
    const auto metric = std::find_if(metrics.begin(), metrics.end(), is_same_quantity);
    if (metric == metrics.end()) return;
    const auto suppress = [&](double& value) { value = results::suppress_round_off(metric->round_off, value); };
    suppress(result.expected_rms);
    if (result.expected_rms == 0) result.square_deviation = 0;
    for (FigureDeviation* figure : {&result.peak, &result.rms, &result.mean, &result.range}) {
      suppress(figure->value);
      suppress(figure->deviation);
      for (double& contribution : figure->contributions) suppress(contribution);
      if (result.expected_rms == 0)
        figure->deviation = 0, figure->contributions.setZero(), figure->extremum_times.clear();
    }
    blank_incompatible_parameters(result);
    for (double* value : {&result.worst.value, &result.worst.deviation}) suppress(*value);
    if (result.worst.deviation == 0) result.worst.shares.setZero();
  }

  void drop_round_off(FigureDeviation& energy) const {
    const VectorX& time = nominal_.time;
    double round_off = 0;
    for (Eigen::Index a = 0; a < nominal_.power.cols(); ++a)
      round_off += column_round_off(nominal_, &RunResult::power, a) * (time[time.size() - 1] - time[0]);
    for (double* value : {&energy.value, &energy.deviation}) *value = results::suppress_round_off(round_off, *value);
    for (double& contribution : energy.contributions)
      contribution = results::suppress_round_off(round_off, contribution);
    blank_incompatible_parameters(energy.contributions);
  }

  void blank_incompatible_parameters(QuantityTolerance& result) const {
    for (FigureDeviation* figure : {&result.peak, &result.rms, &result.mean, &result.range})
      blank_incompatible_parameters(figure->contributions);
  }

  const Tolerances& numbers_;
  RunResult nominal_;
  TolerancedRun toleranced_run_;
};

}  // namespace

ToleranceReport analyse_tolerance(const DesignSpace& space, const Tolerances& numbers, const Trajectory& trajectory,
                                  const std::vector<std::string>& quantities) {
  return ToleranceAnalysis(space, numbers, trajectory, quantities).report(quantities);
}

}  // namespace balance::tolerance
