#include "balance/synthesis/tolerance/extreme_figure.hpp"

#include "balance/synthesis/tolerance/tolerance_sampling.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace balance {

namespace {

/// A moment that is smaller by so many deviations of the difference is never the largest.
constexpr double max_candidate_deviations = 4;
/// Moments whose slopes differ by no more than this part of theirs are one.
constexpr double gradient_merge_tolerance = 0.03;
/// A deviation's standard error is then some half of a hundredth.
constexpr int draw_count = 16384;
constexpr std::uint64_t draw_seed = 1961;
/// Parts of the draws and of the duration.
constexpr double min_extremum_fraction = 0.02, time_merge_fraction = 0.02;

}  // namespace

ExtremeFigure::ExtremeFigure(const std::vector<LinearizedSample>& moments, Kind kind) : kind_(kind) {
  if (moments.empty()) return;
  duration_ = moments.back().time - moments.front().time;
  maximum_candidates_ = find_candidates(moments, 1);
  if (kind_ == Kind::range) minimum_candidates_ = find_candidates(moments, -1);
}

double ExtremeFigure::magnitude(const VectorX& value) const {
  return kind_ == Kind::range && value.size() == 1 ? value[0] : value.norm();
}

ExtremeFigure::ValueWithGradient ExtremeFigure::magnitude_with_gradient(const LinearizedSample& moment,
                                                                        double sign) const {
  const double size = moment.value.norm();
  if (kind_ == Kind::range && moment.value.size() == 1)
    return {sign * moment.value[0], sign * moment.sensitivity.col(0)};
  if (size == 0) return {0, VectorX::Zero(moment.sensitivity.rows())};
  return {sign * size, sign / size * moment.sensitivity * moment.value};
}

std::vector<ExtremeFigure::Candidate> ExtremeFigure::find_candidates(const std::vector<LinearizedSample>& moments,
                                                                     double sign) {
  std::vector<ValueWithGradient> heights;
  for (const LinearizedSample& moment : moments) heights.push_back(magnitude_with_gradient(moment, sign));
  std::vector<std::size_t> order(moments.size()), kept;
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return heights[a].value > heights[b].value; });
  const ValueWithGradient& leader = heights[order.front()];
  near_zero_ = sign < 0 && moments.front().value.size() > 1 &&
               -leader.value < max_candidate_deviations * moments[order.front()].sensitivity.norm();
  for (const std::size_t i : order) {
    const ValueWithGradient& one = heights[i];
    if (near_zero_) {  // a magnitude has no slope there
      if (-one.value < max_candidate_deviations * moments[i].sensitivity.norm()) kept.push_back(i);
      continue;
    }
    if (leader.value - one.value > max_candidate_deviations * (one.gradient - leader.gradient).norm()) continue;
    const double resolution = gradient_merge_tolerance * std::max(one.gradient.norm(), leader.gradient.norm());
    const auto alike = [&](std::size_t k) { return (one.gradient - heights[k].gradient).norm() <= resolution; };
    if (std::none_of(kept.begin(), kept.end(), alike)) kept.push_back(i);
  }
  std::vector<Candidate> rivals;
  for (const std::size_t i : kept) rivals.push_back({moments[i], 0, VectorX::Zero(moments[i].value.size())});
  return rivals;
}

bool ExtremeFigure::has_several_candidates() const {
  return maximum_candidates_.size() > 1 || minimum_candidates_.size() > 1 || near_zero_;
}

/// @return the largest height of that sign there
double ExtremeFigure::update_extremum(std::vector<Candidate>& rivals, double sign, const VectorX& z) const {
  Candidate* winner = nullptr;
  double best = 0;
  VectorX there, winning;
  for (Candidate& rival : rivals) {
    there = rival.sample.value + rival.sample.sensitivity.transpose() * z;
    const double now = sign * magnitude(there);
    if (winner != nullptr && now <= best) continue;
    winner = &rival, best = now, winning = there;
  }
  ++winner->extremum_count;
  const double size = winning.norm();
  if (kind_ == Kind::range && winning.size() == 1)
    winner->gradient_sum[0] += sign;
  else if (size > 0)
    winner->gradient_sum += sign / size * winning;
  return best;
}

void ExtremeFigure::add_draw(const VectorX& z) {
  double figure = update_extremum(maximum_candidates_, 1, z);
  if (kind_ == Kind::range) figure += update_extremum(minimum_candidates_, -1, z);
  if (draws_++ == 0) reference_value_ = figure;  // sums of differences lose no digits
  sum_ += figure - reference_value_;
  sum_of_squares_ += (figure - reference_value_) * (figure - reference_value_);
}

double ExtremeFigure::deviation() const {
  const auto count = static_cast<double>(draws_);
  return std::sqrt(std::max(0.0, sum_of_squares_ - sum_ * sum_ / count) / (count - 1));
}

VectorX ExtremeFigure::contributions() const {
  VectorX out = VectorX::Zero(maximum_candidates_.front().sample.sensitivity.rows());
  for (const std::vector<Candidate>* rivals : {&maximum_candidates_, &minimum_candidates_})
    for (const Candidate& rival : *rivals)
      out += rival.sample.sensitivity * rival.gradient_sum / static_cast<double>(draws_);
  return out;
}

std::vector<double> ExtremeFigure::extremum_times() const {
  std::vector<std::pair<long, double>> by_wins;
  for (const std::vector<Candidate>* rivals : {&maximum_candidates_, &minimum_candidates_})
    for (const Candidate& rival : *rivals)
      if (static_cast<double>(rival.extremum_count) >= min_extremum_fraction * static_cast<double>(draws_))
        by_wins.emplace_back(-rival.extremum_count, rival.sample.time);
  std::sort(by_wins.begin(), by_wins.end());
  std::vector<double> times;
  for (const auto& [wins, time] : by_wins) {
    const double here = time;
    const auto near = [&](double other) { return std::abs(other - here) <= time_merge_fraction * duration_; };
    if (std::none_of(times.begin(), times.end(), near)) times.push_back(time);
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

}  // namespace balance
