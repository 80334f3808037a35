#pragma once
/// A law of motion in the plane of its path's place and rate.

#include "balance/motion/phase_plane.hpp"
#include "balance/motion/schedule.hpp"

namespace balance {

/// Fills the time, place and rate of a phase plane.
void sample_phase_plane(const PrescribedMotion& schedule, PhasePlane& plane);

}  // namespace balance
