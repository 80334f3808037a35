#pragma once
/// What a run tells of payloads that are taken up and set down.

#include "balance/mechanics/model/payload_intervals.hpp"
#include "balance/mechanics/results/result.hpp"

#include <cstddef>
#include <functional>

namespace balance {

/// How the place of a payload moves: speed of its CoM [m/s], angular velocity of its body [rad/s].
struct PayloadMotion {
  double speed = 0, turning = 0;
};

/// From one stretch to the next, with the efforts on both sides.
struct PayloadSwitch {
  double time;
  int before, after;
  const VectorX &effort_before, &effort_after;
};

/// Adds to RunResult::payload_events what is there on one side of the switch alone.
/// @param motion of the payload with this index into Mechanism::attachments, at the switch
void add_payload_changes(const Mechanism& mechanism, const PayloadIntervals& stretches, const PayloadSwitch& change,
                         const std::function<PayloadMotion(std::size_t attachment)>& motion, RunResult& result);

/// Adds a note for every change that is an impact, which the figures leave out, and for every payload that is never there.
/// @param duration of the motion [s]
void add_payload_notes(const Mechanism& mechanism, double duration, RunResult& result);

}  // namespace balance
