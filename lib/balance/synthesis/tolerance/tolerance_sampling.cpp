#include "balance/synthesis/tolerance/tolerance_sampling.hpp"

#include "balance/mechanics/model/validation.hpp"
#include "balance/mechanics/results/metrics.hpp"
#include "balance/mechanics/results/quantities.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace balance::tolerance {

namespace {

constexpr std::array all_figures = {Statistic::peak, Statistic::rms, Statistic::mean, Statistic::range};

/// A figure's values in all mechanisms that ran.
struct FigureDraws {
  std::string quantity, unit;
  std::vector<double> values[all_figures.size()];
};

/// Interpolates between the two neighbours in order.
double quantile(const std::vector<double>& sorted, double probability) {
  const double position = probability * static_cast<double>(sorted.size() - 1);
  const auto low = static_cast<std::size_t>(position);
  const std::size_t high = std::min(low + 1, sorted.size() - 1);
  return sorted[low] + (position - static_cast<double>(low)) * (sorted[high] - sorted[low]);
}

SampledFigure summarise_draws(const FigureDraws& column, std::size_t f) {
  std::vector<double> values = column.values[f];
  const auto count = static_cast<double>(values.size());
  SampledFigure result{.quantity = column.quantity, .unit = column.unit, .figure = all_figures[f]};
  for (const double value : values) result.mean += value / count;
  double squares = 0, fourths = 0;
  for (const double value : values) {
    const double squared_deviation = (value - result.mean) * (value - result.mean);
    squares += squared_deviation;
    fourths += squared_deviation * squared_deviation;
  }
  const double variance = squares / (count - 1);
  result.deviation = std::sqrt(variance);
  result.mean_error = result.deviation / std::sqrt(count);
  if (variance > 0) {
    const double variance_of_variance = std::max(0.0, fourths / count - variance * variance) / count;
    result.deviation_error = std::sqrt(variance_of_variance) / (2 * result.deviation);
  }
  std::sort(values.begin(), values.end());
  result.quantiles = {quantile(values, 0.05), quantile(values, 0.5), quantile(values, 0.95)};
  return result;
}

class MonteCarloRun {
 public:
  MonteCarloRun(const DesignSpace& space, const Tolerances& numbers, const Trajectory& trajectory,
                const std::vector<std::string>& quantities, std::uint64_t seed)
      : space_(space), numbers_(numbers), quantities_(quantities), samples_(trajectory.samples), random_(seed) {
    trajectory_index_ = trajectory_index(space.start, trajectory.name);
  }

  void draw() {
    DesignSpace perturbed = space_;
    std::string rejection;
    for (const study::TolerancedParameter& number : numbers_) {
      const double deviation = random_.draw(number);
      perturbed.inputs[static_cast<std::size_t>(number.input)] += deviation;
      if (number.is_positive && number.value + deviation < 0) rejection = number.path + " below zero";
    }
    if (rejection.empty()) rejection = run(perturbed);
    rejection.empty() ? ++report_.run_count : ++report_.rejections[rejection];
  }

  MonteCarloReport result() {
    if (report_.run_count >= 2)
      for (const FigureDraws& column : columns_)
        for (std::size_t f = 0; f < all_figures.size(); ++f) report_.figures.push_back(summarise_draws(column, f));
    return std::move(report_);
  }

 private:
  /// @return why there are no figures; empty if there are
  std::string run(const DesignSpace& perturbed) {
    const study::RecordedValues<double> values(*perturbed.recording, perturbed.inputs);
    const Mechanism mechanism = values.mechanism();
    if (const std::vector<ValidationIssue> issues = validate(mechanism); !issues.empty())
      return issues.front().message.substr(0, issues.front().message.find(", is "));
    Trajectory trajectory =
        trajectory::cast_scalar<double>(perturbed.recording->trajectories.at(trajectory_index_), values);
    trajectory.samples = samples_;
    try {
      const RunResult result = simulate(mechanism, trajectory);
      if (result.outcome.status != MotionStatus::done) return "an impossible motion";
      record(result);
    } catch (const std::invalid_argument&) {
      return "an invalid motion";
    }
    return "";
  }

  void record(const RunResult& result) {
    std::size_t c = 0;
    for (const Metric& metric : result.metrics) {
      if (!is_requested(metric.quantity)) continue;
      if (c == columns_.size()) columns_.push_back({metric.quantity, metric.unit, {}});
      for (std::size_t f = 0; f < all_figures.size(); ++f)
        columns_[c].values[f].push_back(statistic_of(metric, all_figures[f]));
      ++c;
    }
  }

  bool is_requested(const std::string& quantity) const {
    return quantities_.empty() || std::any_of(quantities_.begin(), quantities_.end(), [&](const std::string& name) {
             return results::is_quantity_or_array_name(name, quantity);
           });
  }

  const DesignSpace& space_;
  const Tolerances& numbers_;
  const std::vector<std::string>& quantities_;
  long samples_;
  std::size_t trajectory_index_ = 0;
  ToleranceSampler random_;
  std::vector<FigureDraws> columns_;
  MonteCarloReport report_;
};

}  // namespace

MonteCarloReport sample_tolerance(const DesignSpace& space, const Tolerances& numbers, const Trajectory& trajectory,
                                  const std::vector<std::string>& quantities, const MonteCarloOptions& options,
                                  const std::function<void(double fraction)>& progress) {
  if (options.count < 2) throw std::invalid_argument("at least two draws are needed");
  MonteCarloRun run(space, numbers, trajectory, quantities, options.seed);
  for (long k = 0; k < options.count; ++k) {
    if (progress) progress(static_cast<double>(k) / static_cast<double>(options.count));
    run.draw();
  }
  return run.result();
}

}  // namespace balance::tolerance
