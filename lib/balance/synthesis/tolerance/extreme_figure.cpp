#include "balance/synthesis/tolerance/extreme_figure.hpp"

#include "balance/synthesis/tolerance/tolerance_sampling.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace balance::tolerance {

namespace {

/// An instant whose value is smaller by this number of deviations of the difference is never the maximum.
constexpr double max_candidate_deviations = 4;
/// Instants whose gradients differ by at most this fraction of their norm count as one.
constexpr double gradient_merge_tolerance = 0.03;
/// The standard error of a deviation is then about half a hundredth.
constexpr int draw_count = 16384;
constexpr std::uint64_t draw_seed = 1961;
/// Fractions of the draws and of the duration.
constexpr double min_extremum_fraction = 0.02, time_merge_fraction = 0.02;

}  // namespace

ExtremeFigure::ExtremeFigure(const std::vector<LinearizedSample>& samples, Kind kind) : kind_(kind) {
  if (samples.empty()) return;
  duration_ = samples.back().time - samples.front().time;
  maximum_candidates_ = find_candidates(samples, 1);
  if (kind_ == Kind::range) minimum_candidates_ = find_candidates(samples, -1);
}

double ExtremeFigure::magnitude(const VectorX& value) const {
  return kind_ == Kind::range && value.size() == 1 ? value[0] : value.norm();
}

ExtremeFigure::ValueWithGradient ExtremeFigure::magnitude_with_gradient(const LinearizedSample& sample,
                                                                        double sign) const {
  const double size = sample.value.norm();
  if (kind_ == Kind::range && sample.value.size() == 1)
    return {sign * sample.value[0], sign * sample.sensitivity.col(0)};
  if (size == 0) return {0, VectorX::Zero(sample.sensitivity.rows())};
  return {sign * size, sign / size * sample.sensitivity * sample.value};
}

std::vector<ExtremeFigure::Candidate> ExtremeFigure::find_candidates(const std::vector<LinearizedSample>& samples,
                                                                     double sign) {
  std::vector<ValueWithGradient> signed_values;
  for (const LinearizedSample& sample : samples) signed_values.push_back(magnitude_with_gradient(sample, sign));
  std::vector<std::size_t> order(samples.size()), selected;
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](auto a, auto b) { return signed_values[a].value > signed_values[b].value; });
  const ValueWithGradient& best = signed_values[order.front()];
  near_zero_ = sign < 0 && samples.front().value.size() > 1 &&
               -best.value < max_candidate_deviations * samples[order.front()].sensitivity.norm();
  for (const std::size_t i : order) {
    const ValueWithGradient& current = signed_values[i];
    if (near_zero_) {  // a magnitude has no gradient there
      if (-current.value < max_candidate_deviations * samples[i].sensitivity.norm()) selected.push_back(i);
      continue;
    }
    if (best.value - current.value > max_candidate_deviations * (current.gradient - best.gradient).norm()) continue;
    const double resolution = gradient_merge_tolerance * std::max(current.gradient.norm(), best.gradient.norm());
    const auto is_similar = [&](std::size_t k) {
      return (current.gradient - signed_values[k].gradient).norm() <= resolution;
    };
    if (std::none_of(selected.begin(), selected.end(), is_similar)) selected.push_back(i);
  }
  std::vector<Candidate> candidates;
  for (const std::size_t i : selected) candidates.push_back({samples[i], 0, VectorX::Zero(samples[i].value.size())});
  return candidates;
}

bool ExtremeFigure::has_several_candidates() const {
  return maximum_candidates_.size() > 1 || minimum_candidates_.size() > 1 || near_zero_;
}

/// @return the maximum of sign · magnitude in this draw
double ExtremeFigure::update_extremum(std::vector<Candidate>& candidates, double sign, const VectorX& z) const {
  Candidate* extremum = nullptr;
  double max_magnitude = 0;
  VectorX value, extremum_value;
  for (Candidate& candidate : candidates) {
    value = candidate.sample.value + candidate.sample.sensitivity.transpose() * z;
    const double signed_magnitude = sign * magnitude(value);
    if (extremum != nullptr && signed_magnitude <= max_magnitude) continue;
    extremum = &candidate, max_magnitude = signed_magnitude, extremum_value = value;
  }
  ++extremum->extremum_count;
  const double size = extremum_value.norm();
  if (kind_ == Kind::range && extremum_value.size() == 1)
    extremum->gradient_sum[0] += sign;
  else if (size > 0)
    extremum->gradient_sum += sign / size * extremum_value;
  return max_magnitude;
}

void ExtremeFigure::add_draw(const VectorX& z) {
  double figure = update_extremum(maximum_candidates_, 1, z);
  if (kind_ == Kind::range) figure += update_extremum(minimum_candidates_, -1, z);
  if (draws_++ == 0) reference_value_ = figure;  // sums of differences do not lose digits
  sum_ += figure - reference_value_;
  sum_of_squares_ += (figure - reference_value_) * (figure - reference_value_);
}

double ExtremeFigure::deviation() const {
  const auto count = static_cast<double>(draws_);
  return std::sqrt(std::max(0.0, sum_of_squares_ - sum_ * sum_ / count) / (count - 1));
}

VectorX ExtremeFigure::contributions() const {
  VectorX result = VectorX::Zero(maximum_candidates_.front().sample.sensitivity.rows());
  for (const std::vector<Candidate>* candidates : {&maximum_candidates_, &minimum_candidates_})
    for (const Candidate& candidate : *candidates)
      result += candidate.sample.sensitivity * candidate.gradient_sum / static_cast<double>(draws_);
  return result;
}

std::vector<double> ExtremeFigure::extremum_times() const {
  std::vector<std::pair<long, double>> by_count;
  for (const std::vector<Candidate>* candidates : {&maximum_candidates_, &minimum_candidates_})
    for (const Candidate& candidate : *candidates)
      if (static_cast<double>(candidate.extremum_count) >= min_extremum_fraction * static_cast<double>(draws_))
        by_count.emplace_back(-candidate.extremum_count, candidate.sample.time);
  std::sort(by_count.begin(), by_count.end());
  std::vector<double> times;
  for (const auto& [count, time] : by_count) {
    const double candidate_time = time;
    const auto is_near = [&](double other) {
      return std::abs(other - candidate_time) <= time_merge_fraction * duration_;
    };
    if (std::none_of(times.begin(), times.end(), is_near)) times.push_back(time);
  }
  std::sort(times.begin(), times.end());
  return times;
}

void sample_extreme_figures(std::vector<ExtremeFigure*>& figures, const Tolerances& numbers) {
  if (figures.empty()) return;
  ToleranceSampler random(draw_seed);
  VectorX z(static_cast<Eigen::Index>(numbers.size()));
  for (int draw = 0; draw < draw_count; ++draw) {
    for (std::size_t i = 0; i < numbers.size(); ++i)
      z[static_cast<Eigen::Index>(i)] = random.draw_standard(numbers[i].distribution);
    for (ExtremeFigure* figure : figures) figure->add_draw(z);
  }
}

}  // namespace balance::tolerance
