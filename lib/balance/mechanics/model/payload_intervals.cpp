#include "balance/mechanics/model/payload_intervals.hpp"

#include <cstdio>
#include <limits>

namespace balance {

namespace {

constexpr double switch_time_tolerance = 1e-11;  // of the duration: what is nearer in time is one switch

void make_permanent(Attachment& one, bool there) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  one.from = -infinity, one.until = infinity;
  if (there) return;
  one.mass = 0;
  one.inertia.setZero();
}

}  // namespace

void PayloadIntervals::find_switch_times(std::vector<double> times) {
  const double same = switch_time_tolerance * duration_;
  std::sort(times.begin(), times.end());
  for (const double time : times) {
    const bool inside = time > same && time < duration_ - same;
    if (inside && (switches_.empty() || time - switches_.back() > same)) switches_.push_back(time);
  }
}

int PayloadIntervals::index_at(double time) const {
  const auto next = std::upper_bound(switches_.begin(), switches_.end(), time + switch_time_tolerance * duration_);
  return static_cast<int>(next - switches_.begin());
}

bool PayloadIntervals::is_attached(std::size_t attachment, int stretch) const {
  if (presence_.empty()) return true;
  const auto k = static_cast<std::size_t>(stretch);
  const double begin = k == 0 ? 0 : switches_[k - 1];
  const double middle = (begin + (k == switches_.size() ? duration_ : switches_[k])) / 2;
  const auto& [taken_up, set_down] = presence_[attachment];
  return taken_up <= middle && middle < set_down;
}

Mechanism mechanism_in_interval(const Mechanism& mechanism, const PayloadIntervals& stretches, int stretch) {
  Mechanism there = mechanism;
  for (std::size_t a = 0; a < there.attachments.size(); ++a)
    make_permanent(there.attachments[a], stretches.is_attached(a, stretch));
  return there;
}

Mechanism mechanism_at_time(const Mechanism& mechanism, double time) {
  Mechanism there = mechanism;
  for (Attachment& one : there.attachments) make_permanent(one, one.from <= time && time < one.until);
  return there;
}

std::vector<std::string> list_payload_notes(const Mechanism& mechanism, double time) {
  char moment[32];
  std::snprintf(moment, sizeof moment, "at %.6g s", time);
  std::vector<std::string> notes;
  for (const Attachment& one : mechanism.attachments)
    if (is_temporary_payload(one))
      notes.push_back(std::string(moment) + " payload '" + one.name + "' is " +
                      (one.from <= time && time < one.until ? "there" : "not there"));
  return notes;
}

}  // namespace balance
