#include "balance/analysis/extreme_figure.hpp"

#include "balance/analysis/tolerance_sampler.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace balance {

namespace {

/// A moment that is smaller by so many deviations of the difference is never the largest.
constexpr double max_deviations = 4;
/// Moments whose slopes differ by no more than this part of theirs are one.
constexpr double slope_resolution = 0.03;
/// A deviation's standard error is then some half of a hundredth.
constexpr int draw_count = 16384;
constexpr std::uint64_t draw_seed = 1961;
/// Parts of the draws and of the duration.
constexpr double min_wins = 0.02, neighbourhood = 0.02;

}  // namespace

ExtremeFigure::ExtremeFigure(const std::vector<LinearMoment>& moments, Kind kind) : kind_(kind) {
  if (moments.empty()) return;
  duration_ = moments.back().time - moments.front().time;
  highest_ = find_rivals(moments, 1);
  if (kind_ == Kind::range) lowest_ = find_rivals(moments, -1);
}

double ExtremeFigure::height(const VectorX& value) const {
  return kind_ == Kind::range && value.size() == 1 ? value[0] : value.norm();
}

ExtremeFigure::Height ExtremeFigure::height_of(const LinearMoment& moment, double sign) const {
  const double size = moment.value.norm();
  if (kind_ == Kind::range && moment.value.size() == 1) return {sign * moment.value[0], sign * moment.change.col(0)};
  if (size == 0) return {0, VectorX::Zero(moment.change.rows())};
  return {sign * size, sign / size * moment.change * moment.value};
}

std::vector<ExtremeFigure::Rival> ExtremeFigure::find_rivals(const std::vector<LinearMoment>& moments, double sign) {
  std::vector<Height> heights;
  for (const LinearMoment& moment : moments) heights.push_back(height_of(moment, sign));
  std::vector<std::size_t> order(moments.size()), kept;
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return heights[a].value > heights[b].value; });
  const Height& leader = heights[order.front()];
  near_zero_ = sign < 0 && moments.front().value.size() > 1 &&
               -leader.value < max_deviations * moments[order.front()].change.norm();
  for (const std::size_t i : order) {
    const Height& one = heights[i];
    if (near_zero_) {  // a magnitude has no slope there
      if (-one.value < max_deviations * moments[i].change.norm()) kept.push_back(i);
      continue;
    }
    if (leader.value - one.value > max_deviations * (one.slope - leader.slope).norm()) continue;
    const double resolution = slope_resolution * std::max(one.slope.norm(), leader.slope.norm());
    const auto alike = [&](std::size_t k) { return (one.slope - heights[k].slope).norm() <= resolution; };
    if (std::none_of(kept.begin(), kept.end(), alike)) kept.push_back(i);
  }
  std::vector<Rival> rivals;
  for (const std::size_t i : kept) rivals.push_back({moments[i], 0, VectorX::Zero(moments[i].value.size())});
  return rivals;
}

bool ExtremeFigure::has_rivals() const { return highest_.size() > 1 || lowest_.size() > 1 || near_zero_; }

/// @return the largest height of that sign there
double ExtremeFigure::settle(std::vector<Rival>& rivals, double sign, const VectorX& z) const {
  Rival* winner = nullptr;
  double best = 0;
  VectorX there, winning;
  for (Rival& rival : rivals) {
    there = rival.moment.value + rival.moment.change.transpose() * z;
    const double now = sign * height(there);
    if (winner != nullptr && now <= best) continue;
    winner = &rival, best = now, winning = there;
  }
  ++winner->wins;
  const double size = winning.norm();
  if (kind_ == Kind::range && winning.size() == 1)
    winner->slope[0] += sign;
  else if (size > 0)
    winner->slope += sign / size * winning;
  return best;
}

void ExtremeFigure::meet(const VectorX& z) {
  double figure = settle(highest_, 1, z);
  if (kind_ == Kind::range) figure += settle(lowest_, -1, z);
  if (met_++ == 0) first_ = figure;  // sums of differences lose no digits
  sum_ += figure - first_;
  squares_ += (figure - first_) * (figure - first_);
}

double ExtremeFigure::deviation() const {
  const auto count = static_cast<double>(met_);
  return std::sqrt(std::max(0.0, squares_ - sum_ * sum_ / count) / (count - 1));
}

VectorX ExtremeFigure::by_number() const {
  VectorX out = VectorX::Zero(highest_.front().moment.change.rows());
  for (const std::vector<Rival>* rivals : {&highest_, &lowest_})
    for (const Rival& rival : *rivals) out += rival.moment.change * rival.slope / static_cast<double>(met_);
  return out;
}

std::vector<double> ExtremeFigure::times() const {
  std::vector<std::pair<long, double>> by_wins;
  for (const std::vector<Rival>* rivals : {&highest_, &lowest_})
    for (const Rival& rival : *rivals)
      if (static_cast<double>(rival.wins) >= min_wins * static_cast<double>(met_))
        by_wins.emplace_back(-rival.wins, rival.moment.time);
  std::sort(by_wins.begin(), by_wins.end());
  std::vector<double> times;
  for (const auto& [wins, time] : by_wins) {
    const double here = time;
    const auto near = [&](double other) { return std::abs(other - here) <= neighbourhood * duration_; };
    if (std::none_of(times.begin(), times.end(), near)) times.push_back(time);
  }
  std::sort(times.begin(), times.end());
  return times;
}

void meet_draws(std::vector<ExtremeFigure*>& figures, const Tolerances& numbers) {
  if (figures.empty()) return;
  ToleranceSampler random(draw_seed);
  VectorX z(static_cast<Eigen::Index>(numbers.size()));
  for (int draw = 0; draw < draw_count; ++draw) {
    for (std::size_t i = 0; i < numbers.size(); ++i)
      z[static_cast<Eigen::Index>(i)] = random.draw_standard(numbers[i].spread);
    for (ExtremeFigure* figure : figures) figure->meet(z);
  }
}

}  // namespace balance
