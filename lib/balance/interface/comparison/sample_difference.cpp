#include "balance/interface/comparison/sample_difference.hpp"

#include "balance/interface/comparison/sampled_curve.hpp"
#include "balance/mechanics/results/metrics.hpp"
#include "balance/mechanics/results/round_off.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <unordered_map>

namespace balance::comparison {
namespace {

/// Sample times relative to the first one, multiplied by `scale`.
VectorX normalise_times(const RunResult& result, double scale) {
  return ((result.time.array() - result.time[0]) * scale).matrix();
}

/// Differences of two runs that both have samples, on a common time scale.
class SeriesDifference {
 public:
  SeriesDifference(const RunResult& base, const RunResult& other)
      : base_time_(normalise_times(base, 1)),
        other_time_(normalise_times(other, have_equal_durations(base, other) || duration_of(other) == 0
                                               ? 1
                                               : duration_of(base) / duration_of(other))) {}

  std::optional<Difference> compute(const QuantitySeries& base, const QuantitySeries& other) const {
    const bool base_is_finer = base_time_.size() > other_time_.size();
    const QuantitySeries& fine = base_is_finer ? base : other;
    const QuantitySeries& coarse = base_is_finer ? other : base;
    const VectorX& times = base_is_finer ? other_time_ : base_time_;
    const SampleInterpolant interpolant(base_is_finer ? base_time_ : other_time_, *fine.samples, fine.first,
                                        fine.count);
    return measure(times, coarse, interpolant);
  }

 private:
  static std::optional<Difference> measure(const VectorX& times, const QuantitySeries& series,
                                           const SampleInterpolant& interpolant) {
    std::optional<Difference> difference;
    double squared_integral = 0, previous = 0, last_time = 0, covered_time = 0;
    for (Eigen::Index k = 0; k < times.size(); ++k) {
      const std::optional<VectorX> value = interpolant.evaluate(times[k]);
      if (!value) continue;
      const double distance = (*value - series.samples->row(k).segment(series.first, series.count).transpose()).norm();
      if (difference) {
        squared_integral += (times[k] - last_time) * (distance * distance + previous * previous) / 2;
        covered_time += times[k] - last_time;
      }
      if (!difference) difference = Difference{distance, times[k], 0};
      if (distance > difference->largest) difference->largest = distance, difference->time = times[k];
      previous = distance, last_time = times[k];
    }
    if (difference) difference->rms = covered_time > 0 ? std::sqrt(squared_integral / covered_time) : previous;
    return difference;
  }

  VectorX base_time_, other_time_;
};

/// Merges the difference of `torque[A1]` into the maximum for `torque`.
void merge_worst_case(std::vector<std::pair<std::string, Difference>>& worst, const std::string& part,
                      const Difference& difference) {
  const std::size_t bracket = part.find('[');
  if (bracket == std::string::npos) return;
  const std::string name = part.substr(0, bracket);
  const auto found = std::find_if(worst.begin(), worst.end(), [&](const auto& one) { return one.first == name; });
  if (found == worst.end()) {
    worst.emplace_back(name, difference);
    return;
  }
  Difference& worst_case = found->second;
  if (difference.largest > worst_case.largest)
    worst_case.largest = difference.largest, worst_case.time = difference.time;
  worst_case.rms = std::max(worst_case.rms, difference.rms);
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
  const SeriesDifference series_difference(base, other);
  const std::vector<QuantitySeries> other_series = list_series(other);
  std::unordered_map<std::string_view, const QuantitySeries*> others_by_name;
  for (const QuantitySeries& series : other_series) others_by_name.emplace(series.quantity, &series);
  std::vector<std::pair<std::string, Difference>> differences, worst;
  for (const QuantitySeries& series : list_series(base)) {
    const auto found = others_by_name.find(series.quantity);
    if (found == others_by_name.end() || found->second->count != series.count) continue;
    std::optional<Difference> difference = series_difference.compute(series, *found->second);
    if (!difference) continue;
    const double round_off = series.round_off + found->second->round_off;
    if (results::suppress_round_off(round_off, difference->largest) == 0) difference = Difference{};
    difference->rms = results::suppress_round_off(round_off, difference->rms);
    differences.emplace_back(series.quantity, *difference);
    merge_worst_case(worst, series.quantity, *difference);
  }
  differences.insert(differences.end(), worst.begin(), worst.end());
  return differences;
}

namespace {

constexpr double sample_time_tolerance = 1e-9;  // of the whole time

}  // namespace

SampleInterpolant::SampleInterpolant(VectorX time, const Samples& samples, int first, int count)
    : time_(std::move(time)),
      samples_(samples),
      first_(first),
      count_(count),
      piece_begins_(find_piece_begins(time_, samples_, first_, count_, 0, time_.size())) {
  piece_begins_.push_back(time_.size());
}

VectorX SampleInterpolant::row(Eigen::Index k) const { return samples_.row(k).segment(first_, count_).transpose(); }

std::optional<VectorX> SampleInterpolant::evaluate(double time) const {
  const Eigen::Index n = time_.size();
  if (n == 0) return std::nullopt;
  const double tolerance = sample_time_tolerance * (time_[n - 1] - time_[0]);
  const auto next_sample = std::lower_bound(time_.begin(), time_.end(), time - tolerance);
  const Eigen::Index k = next_sample - time_.begin();
  if (k == n) return std::nullopt;
  if (std::abs(time_[k] - time) <= tolerance) return row(k);
  if (k == 0) return std::nullopt;
  const auto end = std::upper_bound(piece_begins_.begin(), piece_begins_.end(), k - 1);
  if (*end == k) return std::nullopt;  // the later of the two samples begins a piece
  return interpolate_step(time_, samples_.middleCols(first_, count_), *(end - 1), *end, k).value_at_time(time);
}

std::vector<QuantitySeries> list_series(const RunResult& result) {
  std::vector<QuantitySeries> series;
  for (const results::MetricSeries& metric_series : list_metric_series(result)) {
    const Samples& samples = result.*metric_series.array;
    if (samples.rows() > 0 && samples.rows() == result.time.size())
      series.push_back({metric_series.quantity, &samples, metric_series.first, metric_series.count,
                        column_round_off(result, metric_series.array, metric_series.first)});
  }
  return series;
}

}  // namespace balance::comparison
