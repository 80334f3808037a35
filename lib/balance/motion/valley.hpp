#pragma once
/// The least values of a function of time that is known at growing times and can be computed between them. Private to motion.

#include <array>
#include <cmath>
#include <utility>

namespace balance {

class Valley {
 public:
  struct Place {
    double time = 0, value = INFINITY;
  };

  /// Nothing before is connected with what is seen next.
  void restart() { known_ = 0; }

  /// @param value_at computes the function anywhere from the place seen before last to this one
  /// @param found called with every lowest place: between three of which the middle one is the lowest, to 1e-7 of their distance
  template <class ValueAt, class Found>
  void see(const Place& here, ValueAt&& value_at, Found&& found) {
    places_[0] = places_[1];
    places_[1] = places_[2];
    places_[2] = here;
    if (++known_ < 3) return;
    const auto& [left, middle, right] = places_;
    if (std::isfinite(middle.value) && middle.value <= left.value && middle.value < right.value)
      found(lowest(left, middle, right, value_at));
  }

 private:
  /// Golden section.
  template <class ValueAt>
  static Place lowest(const Place& left, const Place& middle, const Place& right, ValueAt&& value_at) {
    constexpr double golden = 0.38196601125010515;
    double from = left.time, to = right.time;
    const double enough = 1e-9 * (to - from);
    Place best = middle;
    while (to - from > enough) {
      const bool later = to - best.time > best.time - from;
      const double time = best.time + golden * ((later ? to : from) - best.time);
      if (time == best.time) break;
      const Place next{time, value_at(time)};
      if (next.value < best.value) {
        (later ? from : to) = best.time;
        best = next;
      } else {
        (later ? to : from) = next.time;
      }
    }
    return best;
  }

  std::array<Place, 3> places_;
  int known_ = 0;
};

}  // namespace balance
