#pragma once
/// Local minima of a function of time that is sampled at increasing times and can be evaluated in between.

#include <array>
#include <cmath>
#include <utility>

namespace balance::numerics {

class LocalMinimumTracker {
 public:
  struct TimedValue {
    double time = 0, value = INFINITY;
  };

  /// The next sample starts a new sequence.
  void reset() { sample_count_ = 0; }

  /// @param value_at evaluates the function anywhere between the last three samples
  /// @param on_minimum called with every local minimum bracketed by three samples, to 1e-7 of their distance
  template <class ValueAt, class OnMinimum>
  void add_sample(const TimedValue& sample, ValueAt&& value_at, OnMinimum&& on_minimum) {
    samples_[0] = samples_[1];
    samples_[1] = samples_[2];
    samples_[2] = sample;
    if (++sample_count_ < 3) return;
    const auto& [left, middle, right] = samples_;
    if (std::isfinite(middle.value) && middle.value <= left.value && middle.value < right.value)
      on_minimum(golden_section_min(left, middle, right, value_at));
  }

 private:
  /// Golden-section search.
  template <class ValueAt>
  static TimedValue golden_section_min(const TimedValue& left, const TimedValue& middle, const TimedValue& right,
                                       ValueAt&& value_at) {
    constexpr double golden_fraction = 0.38196601125010515;
    double from = left.time, to = right.time;
    const double interval_tolerance = 1e-9 * (to - from);
    TimedValue best = middle;
    while (to - from > interval_tolerance) {
      const bool later = to - best.time > best.time - from;
      const double time = best.time + golden_fraction * ((later ? to : from) - best.time);
      if (time == best.time) break;
      const TimedValue next{time, value_at(time)};
      if (next.value < best.value) {
        (later ? from : to) = best.time;
        best = next;
      } else {
        (later ? to : from) = next.time;
      }
    }
    return best;
  }

  std::array<TimedValue, 3> samples_;
  int sample_count_ = 0;
};

}  // namespace balance::numerics
