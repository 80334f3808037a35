#include "balance/simulation/payload_watch.hpp"

#include <cstdio>
#include <string>

namespace balance {

namespace {

/// Of characteristic lengths or radians in the duration: what is slower is at rest.
constexpr double slowest_impact = 1e-6;

std::string short_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

}  // namespace

void add_payload_changes(const Mechanism& mechanism, const PayloadStretches& stretches, const LoadSwitch& change,
                         const std::function<PayloadMotion(std::size_t)>& motion, Result& result) {
  for (std::size_t a = 0; a < mechanism.attachments.size(); ++a) {
    const bool after = stretches.is_there(a, change.after);
    if (after == stretches.is_there(a, change.before)) continue;
    const Attachment& payload = mechanism.attachments[a];
    const PayloadMotion moves = motion(a);
    const bool turns = !payload.inertia.isZero(0);
    result.payload_changes.push_back({payload.name, after, change.time, moves.speed, turns ? moves.turning : 0,
                                      change.effort_before, change.effort_after});
  }
}

void add_payload_notes(const Mechanism& mechanism, double duration, Result& result) {
  const double length = characteristic_length(mechanism);
  for (const PayloadChange& change : result.payload_changes) {
    const bool moves = change.speed > slowest_impact * length / duration;
    if (!moves && change.turning <= slowest_impact / duration) continue;
    result.outcome.notes.push_back("payload '" + change.payload + "' is " + verb_of(change) + " at " +
                                   short_text(change.time) + " s while it " +
                                   (moves ? "moves at " + short_text(change.speed) + " m/s"
                                          : "turns at " + short_text(change.turning) + " rad/s") +
                                   ": the impact is not in the figures");
  }
  for (const Attachment& payload : mechanism.attachments)
    if (payload.from >= duration)
      result.outcome.notes.push_back("payload '" + payload.name + "' is never there: it is taken up at " +
                                     short_text(payload.from) + " s, and the motion ends at " + short_text(duration) +
                                     " s");
}

}  // namespace balance
