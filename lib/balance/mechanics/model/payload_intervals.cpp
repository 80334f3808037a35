#include "balance/mechanics/model/payload_intervals.hpp"

#include <cstdio>
#include <limits>

namespace balance::model {

namespace {

constexpr double switch_time_tolerance = 1e-11;  // of the duration: switches closer than this coincide

void make_permanent(Attachment& attachment, bool is_attached) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  attachment.from = -infinity, attachment.until = infinity;
  if (!is_attached) detach(attachment);
}

}  // namespace

void PayloadIntervals::find_switch_times(std::vector<double> times) {
  const double tolerance = switch_time_tolerance * duration_;
  std::sort(times.begin(), times.end());
  for (const double time : times) {
    const bool is_inside = time > tolerance && time < duration_ - tolerance;
    if (is_inside && (switches_.empty() || time - switches_.back() > tolerance)) switches_.push_back(time);
  }
}

int PayloadIntervals::index_at(double time) const {
  const auto next = std::upper_bound(switches_.begin(), switches_.end(), time + switch_time_tolerance * duration_);
  return static_cast<int>(next - switches_.begin());
}

bool PayloadIntervals::is_attached(std::size_t attachment, int interval) const {
  if (presence_.empty()) return true;
  const auto k = static_cast<std::size_t>(interval);
  const double begin = k == 0 ? 0 : switches_[k - 1];
  const double middle = (begin + (k == switches_.size() ? duration_ : switches_[k])) / 2;
  const auto& [taken_up, set_down] = presence_[attachment];
  return taken_up <= middle && middle < set_down;
}

void detach(Attachment& attachment) {
  attachment.mass = 0;
  attachment.inertia.setZero();
}

Mechanism mechanism_in_interval(const Mechanism& mechanism, const PayloadIntervals& intervals, int interval) {
  Mechanism result = mechanism;
  for (std::size_t a = 0; a < result.attachments.size(); ++a)
    make_permanent(result.attachments[a], intervals.is_attached(a, interval));
  return result;
}

Mechanism mechanism_at_time(const Mechanism& mechanism, double time) {
  Mechanism result = mechanism;
  for (Attachment& attachment : result.attachments)
    make_permanent(attachment, attachment.from <= time && time < attachment.until);
  return result;
}

std::vector<std::string> list_payload_notes(const Mechanism& mechanism, double time) {
  char time_text[32];
  std::snprintf(time_text, sizeof time_text, "at %.6g s", time);
  std::vector<std::string> notes;
  for (const Attachment& attachment : mechanism.attachments)
    if (is_temporary_payload(attachment))
      notes.push_back(std::string(time_text) + " payload '" + attachment.name + "' is " +
                      (attachment.from <= time && time < attachment.until ? "there" : "not there"));
  return notes;
}

}  // namespace balance::model
