#pragma once
/// Times at which a trajectory is evaluated, in increasing order: every sample, both sides of every jump and, if
/// samples are few, intermediate times.

#include "balance/mechanics/trajectory/motion_source.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace balance::trajectory {

/// Minimum number of steps for peaks, averages and energies, however few samples are requested. By the trapezoidal
/// rule, averages of a rest-to-rest motion are then accurate to about 1e-5.
inline constexpr long min_time_steps = 400;

/// Number of steps from one sample to the next.
inline long substeps_per_sample(long samples) { return std::max(1L, (min_time_steps + samples - 2) / (samples - 1)); }

/// Maximum number of grid points that are not samples.
inline long max_intermediate_rows(const PrescribedMotion& motion, long samples) {
  return 2 * static_cast<long>(motion.jump_times().size()) + (samples - 1) * (substeps_per_sample(samples) - 1);
}

/// Evenly spaced times without jumps; every `substeps`-th is that of a sample.
struct TimeGrid {
  double duration;
  long samples;
  long substeps = substeps_per_sample(samples), steps = (samples - 1) * substeps;

  double time_of(long step) const {
    if (step == steps) return duration;
    const long sample = step / substeps;
    // exactly the times that samples have without substeps
    return step == sample * substeps ? duration * static_cast<double>(sample) / static_cast<double>(samples - 1)
                                     : duration * static_cast<double>(step) / static_cast<double>(steps);
  }
};

/// A point of the traversal.
struct TimeGridPoint {
  enum class Kind { sample, intermediate, before_jump, after_jump };
  Kind kind = Kind::sample;
  long index = 0;                    ///< of the sample or of the jump
  long next_sample = 0;              ///< the first sample at or after it
  bool has_coincident_next = false;  ///< a jump at a grid time: the next grid point holds the values after it
};

/// Moves a source from point to point, and lets it attach and detach payloads on the way.
/// @param visit called with each TimeGridPoint, not evaluated yet; returns false to stop
/// @return false if the source failed (its outcome says why) or `visit` stopped
template <class Visitor>
bool visit_time_grid(MotionSource& source, long samples, Visitor&& visit) {
  source.update_payloads();
  if (!source.begin()) return false;
  const auto move_to = [&](double time) { return source.time() == time || source.advance(time); };
  const PrescribedMotion& motion = source.prescribed_motion();
  const double duration = motion.duration();
  const std::vector<double>& jumps = motion.jump_times();
  const TimeGrid times{duration, samples};
  std::size_t j = 0;
  for (long step = 0; step <= times.steps; ++step) {
    const double time = times.time_of(step);
    const long k = (step + times.substeps - 1) / times.substeps;
    for (; j < jumps.size() && jumps[j] <= time * (1 + 1e-12); ++j) {
      const bool is_at_grid_time = std::abs(jumps[j] - time) <= 1e-12 * duration;
      if (!move_to(is_at_grid_time ? time : jumps[j])) return false;
      source.update_accelerations(Side::before);
      if (!visit(TimeGridPoint{TimeGridPoint::Kind::before_jump, static_cast<long>(j), k, is_at_grid_time}))
        return false;
      source.update_accelerations(Side::after);
      source.update_payloads();
      if (!visit(TimeGridPoint{TimeGridPoint::Kind::after_jump, static_cast<long>(j), k, is_at_grid_time}))
        return false;
    }
    const TimeGridPoint::Kind kind =
        step % times.substeps == 0 ? TimeGridPoint::Kind::sample : TimeGridPoint::Kind::intermediate;
    if (!move_to(time) || !visit(TimeGridPoint{kind, k, k, false})) return false;
  }
  return true;
}

}  // namespace balance::trajectory
