#pragma once
/// How the smallest pivot of a watched matrix goes down along a motion. Private to motion and dynamics.

#include "balance/motion/regularity.hpp"

#include <array>

namespace balance {

class PivotExtrapolation {
 public:
  void add_sample(double pivot, double time) {
    if (pivot < min_pivot_) min_pivot_ = pivot, min_pivot_time_ = time;
    if (pivot < reliable_pivot_threshold) return;
    samples_[0] = samples_[1];
    samples_[1] = samples_[2];
    samples_[2] = {pivot, time};
  }

  /// When the pivot vanishes, going on like a power of the time left: 1/2 (the way leaves the workspace), 1 (crossed) or 2 (touched).
  /// @param found a time at which it has nearly vanished: the answer where the last moments follow none of them
  double extrapolate_zero(double found) const;

 private:
  struct PivotSample {
    double pivot = 0, time = 0;
  };

  /// Below it, round-off in the configuration shows in the pivot.
  static constexpr double reliable_pivot_threshold = 1e-5;

  std::array<PivotSample, 3> samples_;
  double min_pivot_ = near_singular_pivot_threshold, min_pivot_time_ = 0;  ///< the smallest pivot so far
};

}  // namespace balance
