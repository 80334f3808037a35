#pragma once
/// How the smallest pivot of a watched matrix goes down along a motion. Private to motion and dynamics.

#include "balance/motion/regularity.hpp"

#include <array>

namespace balance {

class Approach {
 public:
  void see(double pivot, double time) {
    if (pivot < nearest_) nearest_ = pivot, nearest_time_ = time;
    if (pivot < well_known) return;
    trail_[0] = trail_[1];
    trail_[1] = trail_[2];
    trail_[2] = {pivot, time};
  }

  /// When the pivot vanishes, going on like a power of the time left: 1/2 (the way leaves the workspace), 1 (crossed) or 2 (touched).
  /// @param found a time at which it has nearly vanished: the answer where the last moments follow none of them
  double vanishes(double found) const;

 private:
  struct Moment {
    double pivot = 0, time = 0;
  };

  /// Below it, round-off in the configuration shows in the pivot.
  static constexpr double well_known = 1e-5;

  std::array<Moment, 3> trail_;
  double nearest_ = near_singular, nearest_time_ = 0;  ///< the smallest pivot so far
};

}  // namespace balance
