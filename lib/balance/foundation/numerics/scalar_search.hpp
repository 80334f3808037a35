#pragma once
/// The least values of a function of time that is known at growing times and can be computed between them.

#include <array>
#include <cmath>
#include <utility>

namespace balance {

class LocalMinimumTracker {
 public:
  struct TimedValue {
    double time = 0, value = INFINITY;
  };

  /// Nothing before is connected with what is seen next.
  void reset() { sample_count_ = 0; }

  /// @param value_at computes the function anywhere from the place seen before last to this one
  /// @param found called with every lowest place: between three of which the middle one is the lowest, to 1e-7 of their distance
  template <class ValueAt, class Found>
  void add_sample(const TimedValue& here, ValueAt&& value_at, Found&& found) {
    places_[0] = places_[1];
    places_[1] = places_[2];
    places_[2] = here;
    if (++sample_count_ < 3) return;
    const auto& [left, middle, right] = places_;
    if (std::isfinite(middle.value) && middle.value <= left.value && middle.value < right.value)
      found(golden_section_min(left, middle, right, value_at));
  }

 private:
  /// Golden section.
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

  std::array<TimedValue, 3> places_;
  int sample_count_ = 0;
};

}  // namespace balance
