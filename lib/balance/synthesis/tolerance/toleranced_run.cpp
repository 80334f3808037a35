#include "balance/synthesis/tolerance/toleranced_run.hpp"

#include "balance/mechanics/results/quantities.hpp"
#include "balance/synthesis/tolerance/tolerance_analysis.hpp"

#include <algorithm>
#include <stdexcept>

namespace balance::tolerance {

namespace {

std::vector<ToleranceSample> list_samples(const derivatives::RunGradient& gradient) {
  std::vector<ToleranceSample> samples;
  std::size_t j = 0;
  const std::vector<long>& next = gradient.intermediate.next_sample;
  for (long k = 0; k < gradient.run.time.size(); ++k) {
    for (; j < next.size() && next[j] == k; ++j)
      samples.push_back({true, static_cast<long>(j), gradient.intermediate.rows.time[static_cast<long>(j)]});
    samples.push_back({false, k, gradient.run.time[k]});
  }
  const double duration = samples.back().time - samples.front().time;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const double half_weight = (samples[i].time - samples[i - 1].time) / (2 * duration);
    samples[i - 1].weight += half_weight;
    samples[i].weight += half_weight;
  }
  return samples;
}

std::vector<std::string> list_array_names(const std::vector<std::string>& quantities) {
  std::vector<std::string> arrays;
  for (const std::string& quantity : quantities) arrays.push_back(results::effort_array_name(quantity));
  const bool needs_total_torque = std::find(arrays.begin(), arrays.end(), "total_torque") != arrays.end();
  if (needs_total_torque) arrays.push_back("torque");  // from which total_torque is computed
  if (!arrays.empty()) arrays.push_back("power");
  return arrays;
}

void require_run(const Tolerances& numbers, const Trajectory& trajectory) {
  if (numbers.empty()) throw std::invalid_argument("there are no numbers with tolerances");
  if (is_mechanism_dependent(trajectory))
    throw std::invalid_argument("the trajectory '" + trajectory.name + "' is recomputed for every mechanism");
  if (!trajectory.adaptations.empty())
    throw std::invalid_argument("the trajectory '" + trajectory.name +
                                "' moves counterweights ('adapt'), which have no tolerances");
  if (trajectory.samples * static_cast<long>(numbers.size()) > max_tolerance_samples)
    throw std::invalid_argument("too many samples for " + std::to_string(numbers.size()) + " numbers: at most " +
                                std::to_string(max_tolerance_samples / static_cast<long>(numbers.size())));
}

}  // namespace

double excess_kurtosis(study::Distribution distribution) {
  return distribution == study::Distribution::normal ? 0 : -1.2;
}

TolerancedRun::TolerancedRun(const DesignSpace& space, const Tolerances& numbers, const Trajectory& trajectory,
                             const std::vector<std::string>& quantities)
    : deviations_(static_cast<Eigen::Index>(numbers.size())) {
  require_run(numbers, trajectory);
  for (std::size_t i = 0; i < numbers.size(); ++i) deviations_[static_cast<Eigen::Index>(i)] = numbers[i].deviation();
  const std::vector<std::string> arrays = list_array_names(quantities);
  for (std::size_t first = 0; first < numbers.size(); first += numerics::dual_width) {
    const TolerancedDuals duals(space, numbers, first);
    gradients_.push_back(derivatives::differentiate_run(duals.mechanism(), duals.trajectory(trajectory), arrays));
    if (gradients_.back().run.outcome.status != MotionStatus::done) return;
    figures_.push_back(differentiate_figures(gradients_.back()));
    for (std::size_t i = first; i < std::min(numbers.size(), first + numerics::dual_width); ++i)
      add_incompatible_parameters(gradients_.back().closure_gaps[i - first], i, numbers[i].path, numbers[i].deviation(),
                                  space.start.mechanism, incompatible_parameters_);
  }
  for (const IncompatibleParameter& parameter : incompatible_parameters_)
    deviations_[static_cast<Eigen::Index>(parameter.index)] = 0;
  samples_ = list_samples(gradients_.front());
}

const RunResult& TolerancedRun::derivative(Eigen::Index number, bool is_intermediate) const {
  const derivatives::RunGradient& gradient = gradients_[static_cast<std::size_t>(number) / numerics::dual_width];
  const std::size_t k = static_cast<std::size_t>(number) % numerics::dual_width;
  if (is_intermediate) return gradient.derivatives_between[k].rows;
  return gradient.derivatives[k];
}

VectorX TolerancedRun::value(const results::MetricSeries& series, const ToleranceSample& sample) const {
  const RunResult& rows = sample.is_intermediate ? gradients_.front().intermediate.rows : run();
  return (rows.*series.array).row(sample.row).segment(series.first, series.count).transpose();
}

MatrixX TolerancedRun::contributions(const results::MetricSeries& series, const ToleranceSample& sample) const {
  MatrixX result(deviations_.size(), series.count);
  for (Eigen::Index i = 0; i < deviations_.size(); ++i)
    result.row(i) =
        deviations_[i] *
        (derivative(i, sample.is_intermediate).*series.array).row(sample.row).segment(series.first, series.count);
  return result;
}

}  // namespace balance::tolerance
