#include "balance/model/payload_stretches.hpp"

#include <cstdio>
#include <limits>

namespace balance {

namespace {

constexpr double same_switch = 1e-11;  // of the duration: what is nearer in time is one switch

void let_stay(Attachment& one, bool there) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  one.from = -infinity, one.until = infinity;
  if (there) return;
  one.mass = 0;
  one.inertia.setZero();
}

}  // namespace

void PayloadStretches::find_switches(std::vector<double> times) {
  const double same = same_switch * duration_;
  std::sort(times.begin(), times.end());
  for (const double time : times) {
    const bool inside = time > same && time < duration_ - same;
    if (inside && (switches_.empty() || time - switches_.back() > same)) switches_.push_back(time);
  }
}

int PayloadStretches::from(double time) const {
  const auto next = std::upper_bound(switches_.begin(), switches_.end(), time + same_switch * duration_);
  return static_cast<int>(next - switches_.begin());
}

bool PayloadStretches::is_there(std::size_t attachment, int stretch) const {
  if (presence_.empty()) return true;
  const auto k = static_cast<std::size_t>(stretch);
  const double begin = k == 0 ? 0 : switches_[k - 1];
  const double middle = (begin + (k == switches_.size() ? duration_ : switches_[k])) / 2;
  const auto& [taken_up, set_down] = presence_[attachment];
  return taken_up <= middle && middle < set_down;
}

Mechanism within(const Mechanism& mechanism, const PayloadStretches& stretches, int stretch) {
  Mechanism there = mechanism;
  for (std::size_t a = 0; a < there.attachments.size(); ++a)
    let_stay(there.attachments[a], stretches.is_there(a, stretch));
  return there;
}

Mechanism at_time(const Mechanism& mechanism, double time) {
  Mechanism there = mechanism;
  for (Attachment& one : there.attachments) let_stay(one, one.from <= time && time < one.until);
  return there;
}

std::vector<std::string> payload_notes(const Mechanism& mechanism, double time) {
  char moment[32];
  std::snprintf(moment, sizeof moment, "at %.6g s", time);
  std::vector<std::string> notes;
  for (const Attachment& one : mechanism.attachments)
    if (comes_or_goes(one))
      notes.push_back(std::string(moment) + " payload '" + one.name + "' is " +
                      (one.from <= time && time < one.until ? "there" : "not there"));
  return notes;
}

}  // namespace balance
