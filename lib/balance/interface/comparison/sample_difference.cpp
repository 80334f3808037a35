#include "balance/interface/comparison/sample_difference.hpp"

#include "balance/mechanics/results/metrics.hpp"
#include "balance/mechanics/results/round_off.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <unordered_map>

namespace balance {
namespace {

/// Sampling times from zero, in the base's seconds.
VectorX normalise_times(const RunResult& result, double scale) {
  return ((result.time.array() - result.time[0]) * scale).matrix();
}

/// Of two runs that both have samples, on the same clock.
class SeriesDifference {
 public:
  SeriesDifference(const RunResult& base, const RunResult& other)
      : base_time_(normalise_times(base, 1)),
        other_time_(normalise_times(other, have_equal_durations(base, other) || duration_of(other) == 0
                                               ? 1
                                               : duration_of(base) / duration_of(other))) {}

  std::optional<Difference> of(const QuantitySeries& base, const QuantitySeries& other) const {
    const bool base_is_finer = base_time_.size() > other_time_.size();
    const QuantitySeries& fine = base_is_finer ? base : other;
    const QuantitySeries& coarse = base_is_finer ? other : base;
    const VectorX& times = base_is_finer ? other_time_ : base_time_;
    const SampleInterpolant between(base_is_finer ? base_time_ : other_time_, *fine.samples, fine.first, fine.count);
    return measure(times, coarse, between);
  }

 private:
  static std::optional<Difference> measure(const VectorX& times, const QuantitySeries& series,
                                           const SampleInterpolant& between) {
    std::optional<Difference> difference;
    double squares = 0, last = 0, last_time = 0, covered = 0;
    for (Eigen::Index k = 0; k < times.size(); ++k) {
      const std::optional<VectorX> value = between.evaluate(times[k]);
      if (!value) continue;
      const double apart = (*value - series.samples->row(k).segment(series.first, series.count).transpose()).norm();
      if (difference) {
        squares += (times[k] - last_time) * (apart * apart + last * last) / 2;
        covered += times[k] - last_time;
      }
      if (!difference) difference = Difference{apart, times[k], 0};
      if (apart > difference->largest) difference->largest = apart, difference->time = times[k];
      last = apart, last_time = times[k];
    }
    if (difference) difference->rms = covered > 0 ? std::sqrt(squares / covered) : last;
    return difference;
  }

  VectorX base_time_, other_time_;
};

/// Raises the entry of `torque` to what `torque[A1]` has.
void add_to_worst(std::vector<std::pair<std::string, Difference>>& worst, const std::string& part,
                  const Difference& difference) {
  const std::size_t bracket = part.find('[');
  if (bracket == std::string::npos) return;
  const std::string name = part.substr(0, bracket);
  const auto found = std::find_if(worst.begin(), worst.end(), [&](const auto& one) { return one.first == name; });
  if (found == worst.end()) {
    worst.emplace_back(name, difference);
    return;
  }
  Difference& most = found->second;
  if (difference.largest > most.largest) most.largest = difference.largest, most.time = difference.time;
  most.rms = std::max(most.rms, difference.rms);
}

}  // namespace

double duration_of(const RunResult& result) {
  return result.time.size() == 0 ? 0 : result.time[result.time.size() - 1] - result.time[0];
}

bool have_equal_durations(const RunResult& a, const RunResult& b) {
  return std::abs(duration_of(a) - duration_of(b)) <= 1e-9 * std::max(duration_of(a), duration_of(b));
}

std::vector<std::pair<std::string, Difference>> list_differences(const RunResult& base, const RunResult& other) {
  if (base.time.size() == 0 || other.time.size() == 0) return {};
  const SeriesDifference differencer(base, other);
  const std::vector<QuantitySeries> others = list_series(other);
  std::unordered_map<std::string_view, const QuantitySeries*> by_name;
  for (const QuantitySeries& series : others) by_name.emplace(series.quantity, &series);
  std::vector<std::pair<std::string, Difference>> all, worst;
  for (const QuantitySeries& series : list_series(base)) {
    const auto found = by_name.find(series.quantity);
    if (found == by_name.end() || found->second->count != series.count) continue;
    std::optional<Difference> difference = differencer.of(series, *found->second);
    if (!difference) continue;
    const double round_off = series.round_off + found->second->round_off;
    if (suppress_round_off(round_off, difference->largest) == 0) difference = Difference{};
    difference->rms = suppress_round_off(round_off, difference->rms);
    all.emplace_back(series.quantity, *difference);
    add_to_worst(worst, series.quantity, *difference);
  }
  all.insert(all.end(), worst.begin(), worst.end());
  return all;
}

namespace {

constexpr double jump_slope_ratio = 10;  // than its neighbours: smooth samples that are worth comparing never come near
constexpr double sample_time_tolerance = 1e-9;  // of the whole time
constexpr double jump_epsilon = 1e-9;           // of the largest sample: steps of round-off are no jumps
constexpr Eigen::Index stencil_size = 4;        // samples that a value between is made of

}  // namespace

SampleInterpolant::SampleInterpolant(VectorX time, const Samples& samples, int first, int count)
    : time_(std::move(time)), samples_(samples), first_(first), count_(count) {
  find_jumps();
}

VectorX SampleInterpolant::row(Eigen::Index k) const { return samples_.row(k).segment(first_, count_).transpose(); }

void SampleInterpolant::find_jumps() {
  const Eigen::Index n = time_.size();
  VectorX step(std::max<Eigen::Index>(n, 1)), slope(step.size());
  step[0] = slope[0] = 0;
  double largest = 0;
  for (Eigen::Index k = 0; k < n; ++k) largest = std::max(largest, row(k).norm());
  for (Eigen::Index k = 1; k < n; ++k) {
    step[k] = (row(k) - row(k - 1)).norm();
    slope[k] = step[k] / (time_[k] - time_[k - 1]);
  }
  piece_begins_ = {0};
  for (Eigen::Index k = 1; k < n; ++k) {
    // Two steps beside it; one alone may happen to be flat.
    const Eigen::Index from = std::clamp<Eigen::Index>(k - 1, 1, std::max<Eigen::Index>(n - 3, 1));
    double beside = 0;
    for (Eigen::Index i = from; i < std::min(from + 3, n); ++i) beside = i == k ? beside : std::max(beside, slope[i]);
    if (n > 3 && step[k] > jump_epsilon * largest && slope[k] > jump_slope_ratio * beside) piece_begins_.push_back(k);
  }
  piece_begins_.push_back(n);
}

std::optional<VectorX> SampleInterpolant::evaluate(double time) const {
  const Eigen::Index n = time_.size();
  if (n == 0) return std::nullopt;
  const double tolerance = sample_time_tolerance * (time_[n - 1] - time_[0]);
  const auto later = std::lower_bound(time_.begin(), time_.end(), time - tolerance);
  const Eigen::Index k = later - time_.begin();
  if (k == n) return std::nullopt;
  if (std::abs(time_[k] - time) <= tolerance) return row(k);
  if (k == 0) return std::nullopt;
  const auto end = std::upper_bound(piece_begins_.begin(), piece_begins_.end(), k - 1);
  if (*end == k) return std::nullopt;  // a piece begins with the later of the two
  const Eigen::Index points = std::min(stencil_size, *end - *(end - 1));
  const Eigen::Index from = std::clamp(k - points / 2, *(end - 1), *end - points);
  VectorX value = VectorX::Zero(count_);
  for (Eigen::Index i = from; i < from + points; ++i) {
    double weight = 1;  // of Lagrange
    for (Eigen::Index j = from; j < from + points; ++j) {
      if (j != i) weight *= (time - time_[j]) / (time_[i] - time_[j]);
    }
    value += weight * row(i);
  }
  return value;
}

std::vector<QuantitySeries> list_series(const RunResult& result) {
  std::vector<QuantitySeries> all;
  for (const MetricSeries& track : list_metric_series(result)) {
    const Samples& samples = result.*track.array;
    if (samples.rows() > 0 && samples.rows() == result.time.size())
      all.push_back(
          {track.quantity, &samples, track.first, track.count, column_round_off(result, track.array, track.first)});
  }
  return all;
}

}  // namespace balance
