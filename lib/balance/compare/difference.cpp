#include "balance/compare/difference.hpp"

#include "balance/compare/interpolant.hpp"
#include "balance/compare/series.hpp"
#include "balance/result/round_off.hpp"

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

}  // namespace balance
