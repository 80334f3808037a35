#include "balance/motion/simulation/payload_events.hpp"

#include <cstdio>
#include <string>

namespace balance::simulation {

namespace {

/// In characteristic lengths or radians per duration: slower payloads are at rest.
constexpr double impact_speed_threshold = 1e-6;

std::string format_short(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

}  // namespace

void add_payload_changes(const Mechanism& mechanism, const model::PayloadIntervals& intervals,
                         const PayloadSwitch& payload_switch, const std::function<PayloadMotion(std::size_t)>& motion,
                         RunResult& result) {
  for (std::size_t a = 0; a < mechanism.attachments.size(); ++a) {
    const bool is_attached_after = intervals.is_attached(a, payload_switch.after);
    if (is_attached_after == intervals.is_attached(a, payload_switch.before)) continue;
    const Attachment& payload = mechanism.attachments[a];
    const PayloadMotion payload_motion = motion(a);
    const bool has_inertia = !payload.inertia.isZero(0);
    result.payload_events.push_back({payload.name, is_attached_after, payload_switch.time, payload_motion.speed,
                                     has_inertia ? payload_motion.turning : 0, payload_switch.effort_before,
                                     payload_switch.effort_after});
  }
}

void add_payload_notes(const Mechanism& mechanism, double duration, RunResult& result) {
  const double length = characteristic_length(mechanism);
  for (const results::PayloadEvent& event : result.payload_events) {
    if (event.impact_loss) continue;  // the impact is part of the motion
    const bool is_translating = event.speed > impact_speed_threshold * length / duration;
    if (!is_translating && event.angular_speed <= impact_speed_threshold / duration) continue;
    result.outcome.notes.push_back("payload '" + event.payload + "' is " + describe_payload_event(event) + " at " +
                                   format_short(event.time) + " s while it " +
                                   (is_translating ? "moves at " + format_short(event.speed) + " m/s"
                                                   : "turns at " + format_short(event.angular_speed) + " rad/s") +
                                   ": the figures do not include the impact");
  }
  for (const Attachment& payload : mechanism.attachments)
    if (payload.from >= duration)
      result.outcome.notes.push_back("payload '" + payload.name + "' is never there: it is taken up at " +
                                     format_short(payload.from) + " s, and the motion ends at " +
                                     format_short(duration) + " s");
}

}  // namespace balance::simulation
