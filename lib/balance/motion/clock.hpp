#pragma once
/// A law of motion put on a stretch of time.

#include "balance/motion/law.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace balance {

/// Immutable; says how far along its curve a leg is at a time.
class TimeScaling {
 public:
  /// @param start when the leg begins [s]
  /// @param duration how long it takes, positive [s]
  /// @param tolerance times nearer than this to a jump of the law count as the jump itself [s]
  TimeScaling(const MotionLaw& law, double start, double duration, double tolerance)
      : law_(law),
        jumps_(balance::find_acceleration_jumps(law)),
        start_(start),
        duration_(duration),
        rate_(1 / duration),
        tolerance_(tolerance / duration) {}

  /// s, ds/dt [1/s] and d²s/dt² [1/s^2]; before the start and after the end the values there.
  MotionLawValue at(double time, Side side) const {
    double tau = std::clamp((time - start_) / duration_, 0.0, 1.0);
    // Grid times such as k T / (N − 1) miss a jump at T / 2 by round-off; without this the side would not be honoured
    // there.
    for (const double jump : jumps_) {
      if (std::abs(tau - jump) <= tolerance_) tau = jump;
    }
    const MotionLawValue value = evaluate(law_, tau, side);
    return {value.s, value.ds * rate_, value.dds * rate_ * rate_};
  }

  double start() const { return start_; }
  double duration() const { return duration_; }

  /// Times inside the leg at which the law's second derivative jumps, increasing [s].
  std::vector<double> jumps() const {
    std::vector<double> times = jumps_;
    for (double& time : times) time = start_ + time * duration_;
    return times;
  }

 private:
  MotionLaw law_;
  std::vector<double> jumps_;  ///< as parts of the duration
  double start_, duration_;
  double rate_;       ///< of τ [1/s]
  double tolerance_;  ///< as a part of the duration
};

}  // namespace balance
