#include "balance/synthesis/tolerance/tolerance_sampling.hpp"

#include "balance/mechanics/model/validation.hpp"
#include "balance/mechanics/results/metrics.hpp"
#include "balance/mechanics/results/quantities.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace balance {

namespace {

constexpr std::array all_figures = {Statistic::peak, Statistic::rms, Statistic::mean, Statistic::range};

/// A figure's values in all mechanisms that ran.
struct FigureDraws {
  std::string quantity, unit;
  std::vector<double> values[all_figures.size()];
};

/// Between the two neighbours in order.
double quantile(const std::vector<double>& sorted, double part) {
  const double place = part * static_cast<double>(sorted.size() - 1);
  const auto low = static_cast<std::size_t>(place);
  const std::size_t high = std::min(low + 1, sorted.size() - 1);
  return sorted[low] + (place - static_cast<double>(low)) * (sorted[high] - sorted[low]);
}

SampledFigure summarise_draws(const FigureDraws& column, std::size_t f) {
  std::vector<double> values = column.values[f];
  const auto count = static_cast<double>(values.size());
  SampledFigure out{.quantity = column.quantity, .unit = column.unit, .figure = all_figures[f]};
  for (const double value : values) out.mean += value / count;
  double squares = 0, fourths = 0;
  for (const double value : values) {
    const double square = (value - out.mean) * (value - out.mean);
    squares += square;
    fourths += square * square;
  }
  const double variance = squares / (count - 1);
  out.deviation = std::sqrt(variance);
  out.mean_error = out.deviation / std::sqrt(count);
  if (variance > 0) {
    const double of_variance = std::max(0.0, fourths / count - variance * variance) / count;
    out.deviation_error = std::sqrt(of_variance) / (2 * out.deviation);
  }
  std::sort(values.begin(), values.end());
  out.quantiles = {quantile(values, 0.05), quantile(values, 0.5), quantile(values, 0.95)};
  return out;
}

class MonteCarloRun {
 public:
  MonteCarloRun(const DesignSpace& space, const Tolerances& numbers, const Trajectory& trajectory,
                const std::vector<std::string>& quantities, std::uint64_t seed)
      : space_(space), numbers_(numbers), quantities_(quantities), samples_(trajectory.samples), random_(seed) {
    const auto& all = space.start.trajectories;
    const auto same = [&](const Trajectory& one) { return one.name == trajectory.name; };
    which_ = static_cast<std::size_t>(std::find_if(all.begin(), all.end(), same) - all.begin());
  }

  void draw() {
    DesignSpace drawn = space_;
    std::string why;
    for (const TolerancedParameter& number : numbers_) {
      const double off = random_.draw(number);
      drawn.inputs[static_cast<std::size_t>(number.input)] += off;
      if (number.is_positive && number.value + off < 0) why = number.path + " below zero";
    }
    if (why.empty()) why = run(drawn);
    why.empty() ? ++out_.run_count : ++out_.rejections[why];
  }

  MonteCarloReport result() {
    if (out_.run_count >= 2)
      for (const FigureDraws& column : columns_)
        for (std::size_t f = 0; f < all_figures.size(); ++f) out_.figures.push_back(summarise_draws(column, f));
    return std::move(out_);
  }

 private:
  /// @return why there are no figures
  std::string run(const DesignSpace& drawn) {
    const RecordedValues<double> values(*drawn.recording, drawn.inputs);
    const Mechanism mechanism = values.mechanism();
    if (const std::vector<ValidationIssue> faults = validate(mechanism); !faults.empty())
      return faults.front().message.substr(0, faults.front().message.find(", is "));
    Trajectory trajectory = cast_scalar<double>(drawn.recording->trajectories.at(which_), values);
    trajectory.samples = samples_;
    try {
      const RunResult result = simulate(mechanism, trajectory);
      if (result.outcome.status != MotionStatus::done) return "a motion that cannot be made";
      record(result);
    } catch (const std::invalid_argument&) {
      return "a motion that cannot be stated";
    }
    return "";
  }

  void record(const RunResult& result) {
    std::size_t c = 0;
    for (const Metric& metric : result.metrics) {
      if (!wanted(metric.quantity)) continue;
      if (c == columns_.size()) columns_.push_back({metric.quantity, metric.unit, {}});
      for (std::size_t f = 0; f < all_figures.size(); ++f)
        columns_[c].values[f].push_back(statistic_of(metric, all_figures[f]));
      ++c;
    }
  }

  bool wanted(const std::string& quantity) const {
    return quantities_.empty() || std::any_of(quantities_.begin(), quantities_.end(), [&](const std::string& one) {
             return is_quantity_or_array_name(one, quantity);
           });
  }

  const DesignSpace& space_;
  const Tolerances& numbers_;
  const std::vector<std::string>& quantities_;
  long samples_;
  std::size_t which_ = 0;
  ToleranceSampler random_;
  std::vector<FigureDraws> columns_;
  MonteCarloReport out_;
};

}  // namespace

MonteCarloReport sample_tolerance(const DesignSpace& space, const Tolerances& numbers, const Trajectory& trajectory,
                                  const std::vector<std::string>& quantities, const MonteCarloOptions& draws,
                                  const std::function<void(double part)>& progress) {
  if (draws.count < 2) throw std::invalid_argument("at least two draws are needed");
  MonteCarloRun all(space, numbers, trajectory, quantities, draws.seed);
  for (long k = 0; k < draws.count; ++k) {
    if (progress) progress(static_cast<double>(k) / static_cast<double>(draws.count));
    all.draw();
  }
  return all.result();
}

}  // namespace balance
