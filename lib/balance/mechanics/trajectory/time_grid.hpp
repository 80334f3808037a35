#pragma once
/// The way through a trajectory: every sample, both sides of every jump and, where samples are few, more places between them,
/// in the order of time.

#include "balance/mechanics/trajectory/prescribed_motion.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace balance {

/// Peaks, averages and energies rest on at least so many steps, however few samples are asked for: by the trapezoidal rule the
/// averages of a motion from rest to rest are then good to some 1e-5.
inline constexpr long min_time_steps = 400;

/// Steps from one sample to the next.
inline long substeps_per_sample(long samples) { return std::max(1L, (min_time_steps + samples - 2) / (samples - 1)); }

/// Places of a walk that are no samples, at most.
inline long max_intermediate_rows(const PrescribedMotion& schedule, long samples) {
  return 2 * static_cast<long>(schedule.jump_times().size()) + (samples - 1) * (substeps_per_sample(samples) - 1);
}

/// The times of a walk, jumps aside: evenly spaced, every `pieces`-th is a sample's.
struct TimeGrid {
  double duration;
  long samples;
  long substeps = substeps_per_sample(samples), steps = (samples - 1) * substeps;

  double time_of(long step) const {
    if (step == steps) return duration;
    const long sample = step / substeps;
    // samples where they are without steps between them, to the last digit
    return step == sample * substeps ? duration * static_cast<double>(sample) / static_cast<double>(samples - 1)
                                     : duration * static_cast<double>(step) / static_cast<double>(steps);
  }
};

/// Where a walk stands.
struct TimeGridPoint {
  enum class Kind { sample, intermediate, before_jump, after_jump };
  Kind kind = Kind::sample;
  long index = 0;                    ///< of the sample or of the jump
  long next_sample = 0;              ///< the first sample at or after it
  bool has_coincident_next = false;  ///< a jump whose after side the very next stop holds, at the same time
};

/// Leads a stepper of either formulation from stop to stop.
/// @param stepper begin(), advance(time), update_accelerations(side), time()
/// @param see called with each TimeGridPoint; false ends the walk
/// @return false if the stepper got stuck (its outcome says why) or `see` ended the walk
template <class Stepper, class See>
bool visit_time_grid(Stepper& stepper, const PrescribedMotion& schedule, long samples, See&& see) {
  bool started = false;
  const auto move = [&](double time) {
    if (started && stepper.time() == time) return true;
    const bool moved = started ? stepper.advance(time) : stepper.begin();
    started = true;
    return moved;
  };
  const double duration = schedule.duration();
  const std::vector<double>& jumps = schedule.jump_times();
  const TimeGrid times{duration, samples};
  std::size_t j = 0;
  for (long step = 0; step <= times.steps; ++step) {
    const double time = times.time_of(step);
    const long k = (step + times.substeps - 1) / times.substeps;
    for (; j < jumps.size() && jumps[j] <= time * (1 + 1e-12); ++j) {
      const bool here = std::abs(jumps[j] - time) <= 1e-12 * duration;
      if (!move(here ? time : jumps[j])) return false;
      stepper.update_accelerations(Side::before);
      if (!see(TimeGridPoint{TimeGridPoint::Kind::before_jump, static_cast<long>(j), k, here})) return false;
      stepper.update_accelerations(Side::after);
      if (!see(TimeGridPoint{TimeGridPoint::Kind::after_jump, static_cast<long>(j), k, here})) return false;
    }
    const TimeGridPoint::Kind kind =
        step % times.substeps == 0 ? TimeGridPoint::Kind::sample : TimeGridPoint::Kind::intermediate;
    if (!move(time) || !see(TimeGridPoint{kind, k, k, false})) return false;
  }
  return true;
}

}  // namespace balance
