#pragma once
/// The way through a trajectory: every sample and both sides of every jump, in the order of time.

#include "balance/motion/schedule.hpp"

#include <cmath>
#include <vector>

namespace balance {

/// Where a walk stands.
struct Stop {
  enum class Kind { sample, before_jump, after_jump };
  Kind kind = Kind::sample;
  long index = 0;          ///< of the sample or of the jump
  long next_sample = 0;    ///< the first sample at or after it
  bool on_sample = false;  ///< a jump that happens at that very sample, which holds its after side
};

/// Leads a stepper of either formulation from stop to stop.
/// @param stepper begin(), advance(time), accelerate(side), time()
/// @param see called with each Stop; false ends the walk
/// @return false if the stepper got stuck (its outcome says why) or `see` ended the walk
template <class Stepper, class See>
bool walk(Stepper& stepper, const Schedule& schedule, long samples, See&& see) {
  bool started = false;
  const auto move = [&](double time) {
    if (started && stepper.time() == time) return true;
    const bool moved = started ? stepper.advance(time) : stepper.begin();
    started = true;
    return moved;
  };
  const double duration = schedule.duration();
  const std::vector<double>& jumps = schedule.jumps();
  std::size_t j = 0;
  for (long k = 0; k < samples; ++k) {
    const double time =
        k == samples - 1 ? duration : duration * static_cast<double>(k) / static_cast<double>(samples - 1);
    for (; j < jumps.size() && jumps[j] <= time * (1 + 1e-12); ++j) {
      const bool here = std::abs(jumps[j] - time) <= 1e-12 * duration;
      if (!move(here ? time : jumps[j])) return false;
      stepper.accelerate(Side::before);
      if (!see(Stop{Stop::Kind::before_jump, static_cast<long>(j), k, here})) return false;
      stepper.accelerate(Side::after);
      if (!see(Stop{Stop::Kind::after_jump, static_cast<long>(j), k, here})) return false;
    }
    if (!move(time) || !see(Stop{Stop::Kind::sample, k, k, true})) return false;
  }
  return true;
}

}  // namespace balance
