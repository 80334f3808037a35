#include "balance/motion/simulation/payload_events.hpp"

#include <cstdio>
#include <string>

namespace balance {

namespace {

/// Of characteristic lengths or radians in the duration: what is slower is at rest.
constexpr double impact_speed_threshold = 1e-6;

std::string format_short(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

}  // namespace

void add_payload_changes(const Mechanism& mechanism, const PayloadIntervals& stretches, const PayloadSwitch& change,
                         const std::function<PayloadMotion(std::size_t)>& motion, RunResult& result) {
  for (std::size_t a = 0; a < mechanism.attachments.size(); ++a) {
    const bool after = stretches.is_attached(a, change.after);
    if (after == stretches.is_attached(a, change.before)) continue;
    const Attachment& payload = mechanism.attachments[a];
    const PayloadMotion moves = motion(a);
    const bool turns = !payload.inertia.isZero(0);
    result.payload_events.push_back({payload.name, after, change.time, moves.speed, turns ? moves.turning : 0,
                                     change.effort_before, change.effort_after});
  }
}

void add_payload_notes(const Mechanism& mechanism, double duration, RunResult& result) {
  const double length = characteristic_length(mechanism);
  for (const PayloadEvent& change : result.payload_events) {
    const bool moves = change.speed > impact_speed_threshold * length / duration;
    if (!moves && change.angular_speed <= impact_speed_threshold / duration) continue;
    result.outcome.notes.push_back("payload '" + change.payload + "' is " + describe_payload_event(change) + " at " +
                                   format_short(change.time) + " s while it " +
                                   (moves ? "moves at " + format_short(change.speed) + " m/s"
                                          : "turns at " + format_short(change.angular_speed) + " rad/s") +
                                   ": the impact is not in the figures");
  }
  for (const Attachment& payload : mechanism.attachments)
    if (payload.from >= duration)
      result.outcome.notes.push_back("payload '" + payload.name + "' is never there: it is taken up at " +
                                     format_short(payload.from) + " s, and the motion ends at " +
                                     format_short(duration) + " s");
}

}  // namespace balance
