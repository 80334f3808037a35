#include "balance/synthesis/tolerance/toleranced_run.hpp"

#include "balance/mechanics/results/quantities.hpp"
#include "balance/synthesis/tolerance/tolerance_analysis.hpp"

#include <algorithm>
#include <stdexcept>

namespace balance {

namespace {

std::vector<ToleranceSample> instants_of(const RunGradient& gradient) {
  std::vector<ToleranceSample> places;
  std::size_t j = 0;
  const std::vector<long>& next = gradient.intermediate.next_sample;
  for (long k = 0; k < gradient.run.time.size(); ++k) {
    for (; j < next.size() && next[j] == k; ++j)
      places.push_back({true, static_cast<long>(j), gradient.intermediate.rows.time[static_cast<long>(j)]});
    places.push_back({false, k, gradient.run.time[k]});
  }
  const double duration = places.back().time - places.front().time;
  for (std::size_t i = 1; i < places.size(); ++i) {
    const double half = (places[i].time - places[i - 1].time) / (2 * duration);
    places[i - 1].weight += half;
    places[i].weight += half;
  }
  return places;
}

std::vector<std::string> arrays_named(const std::vector<std::string>& quantities) {
  std::vector<std::string> arrays;
  for (const std::string& quantity : quantities) arrays.push_back(effort_array_name(quantity));
  const bool total = std::find(arrays.begin(), arrays.end(), "total_torque") != arrays.end();
  if (total) arrays.push_back("torque");  // what it is the root of
  if (!arrays.empty()) arrays.push_back("power");
  return arrays;
}

void require_run(const Tolerances& numbers, const Trajectory& trajectory) {
  if (numbers.empty()) throw std::invalid_argument("there are no numbers that may be off");
  if (is_mechanism_dependent(trajectory))
    throw std::invalid_argument("the trajectory '" + trajectory.name + "' is found anew for every mechanism");
  if (trajectory.samples * static_cast<long>(numbers.size()) > max_tolerance_samples)
    throw std::invalid_argument("too many samples for " + std::to_string(numbers.size()) + " numbers: at most " +
                                std::to_string(max_tolerance_samples / static_cast<long>(numbers.size())));
}

}  // namespace

double excess_kurtosis(Distribution spread) { return spread == Distribution::normal ? 0 : -1.2; }

TolerancedRun::TolerancedRun(const DesignSpace& space, const Tolerances& numbers, const Trajectory& trajectory,
                             const std::vector<std::string>& quantities)
    : sigma_(static_cast<Eigen::Index>(numbers.size())) {
  require_run(numbers, trajectory);
  for (std::size_t i = 0; i < numbers.size(); ++i) sigma_[static_cast<Eigen::Index>(i)] = numbers[i].deviation();
  const std::vector<std::string> arrays = arrays_named(quantities);
  for (std::size_t first = 0; first < numbers.size(); first += dual_width) {
    const TolerancedDuals duals(space, numbers, first);
    gradients_.push_back(differentiate_run(duals.mechanism(), duals.trajectory(trajectory), arrays));
    if (gradients_.back().run.outcome.status != MotionStatus::done) return;
    figures_.push_back(differentiate_figures(gradients_.back()));
    for (std::size_t i = first; i < std::min(numbers.size(), first + dual_width); ++i)
      add_incompatible_parameters(gradients_.back().closure_gaps[i - first], i, numbers[i].path, numbers[i].deviation(),
                                  space.start.mechanism, incompatible_parameters_);
  }
  for (const IncompatibleParameter& one : incompatible_parameters_) sigma_[static_cast<Eigen::Index>(one.index)] = 0;
  places_ = instants_of(gradients_.front());
}

const RunResult& TolerancedRun::derivative(Eigen::Index number, bool between) const {
  const RunGradient& gradient = gradients_[static_cast<std::size_t>(number) / dual_width];
  const std::size_t k = static_cast<std::size_t>(number) % dual_width;
  if (between) return gradient.derivatives_between[k].rows;
  return gradient.derivatives[k];
}

VectorX TolerancedRun::value(const MetricSeries& track, const ToleranceSample& place) const {
  const RunResult& rows = place.is_intermediate ? gradients_.front().intermediate.rows : run();
  return (rows.*track.array).row(place.row).segment(track.first, track.count).transpose();
}

MatrixX TolerancedRun::contributions(const MetricSeries& track, const ToleranceSample& place) const {
  MatrixX out(sigma_.size(), track.count);
  for (Eigen::Index i = 0; i < sigma_.size(); ++i)
    out.row(i) = sigma_[i] *
                 (derivative(i, place.is_intermediate).*track.array).row(place.row).segment(track.first, track.count);
  return out;
}

}  // namespace balance
