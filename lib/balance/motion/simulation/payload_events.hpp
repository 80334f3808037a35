#pragma once
/// Events and notes of a run with payloads that are taken up or set down.

#include "balance/mechanics/model/payload_intervals.hpp"
#include "balance/mechanics/results/result.hpp"

#include <cstddef>
#include <functional>

namespace balance::simulation {

/// Motion of a payload: speed of its CoM [m/s], angular velocity of its body [rad/s].
struct PayloadMotion {
  double speed = 0, turning = 0;
};

/// From one interval to the next, with the efforts on both sides.
struct PayloadSwitch {
  double time;
  int before, after;
  const VectorX &effort_before, &effort_after;
};

/// Adds the payloads that are attached on only one side of the switch to RunResult::payload_events.
/// @param motion of the payload with this index into Mechanism::attachments, at the switch
void add_payload_changes(const Mechanism& mechanism, const model::PayloadIntervals& intervals,
                         const PayloadSwitch& payload_switch,
                         const std::function<PayloadMotion(std::size_t attachment)>& motion, RunResult& result);

/// Adds a note for every change that is an impact, which figures do not include, and for every payload that is never
/// attached.
/// @param duration of the motion [s]
void add_payload_notes(const Mechanism& mechanism, double duration, RunResult& result);

}  // namespace balance::simulation
