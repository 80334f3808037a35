#pragma once
/// When payloads are there that are taken up or set down while a mechanism moves (AttachmentOf::from, until).

#include "balance/mechanics/model/mechanism.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace balance {

/// Its mass does not always move with its body.
template <class T>
bool is_temporary_payload(const AttachmentOf<T>& one) {
  return std::isfinite(one.from) || std::isfinite(one.until);
}

template <class T>
bool has_temporary_payloads(const MechanismOf<T>& mechanism) {
  return std::any_of(mechanism.attachments.begin(), mechanism.attachments.end(),
                     [](const AttachmentOf<T>& one) { return is_temporary_payload(one); });
}

/// All times at which something is taken up or set down, in no order, each as often as it is said [s].
template <class T>
std::vector<double> payload_switch_times(const MechanismOf<T>& mechanism) {
  std::vector<double> times;
  for (const AttachmentOf<T>& one : mechanism.attachments)
    for (const double time : {one.from, one.until})
      if (std::isfinite(time)) times.push_back(time);
  return times;
}

/// The stretches of a motion within which nothing is taken up or set down.
class PayloadIntervals {
 public:
  /// One stretch, in which everything is there.
  PayloadIntervals() = default;
  /// @param duration of the motion, which begins at time 0 [s]
  template <class T>
  PayloadIntervals(const MechanismOf<T>& mechanism, double duration) : duration_(duration) {
    for (const AttachmentOf<T>& one : mechanism.attachments) presence_.emplace_back(one.from, one.until);
    find_switch_times(payload_switch_times(mechanism));
  }

  /// Times strictly inside the motion at which something is taken up or set down, increasing [s].
  const std::vector<double>& switch_times() const { return switches_; }
  int count() const { return static_cast<int>(switches_.size()) + 1; }
  /// The stretch that a time belongs to; at a switch the one that begins there.
  int index_at(double time) const;
  /// @param attachment index into Mechanism::attachments
  bool is_attached(std::size_t attachment, int stretch) const;

 private:
  void find_switch_times(std::vector<double> times);

  double duration_ = 1;
  std::vector<std::pair<double, double>> presence_;  ///< per attachment: from, until
  std::vector<double> switches_;
};

/// The mechanism as it is in one stretch: what is not there has no mass. Nothing comes or goes any more; bodies, names and indices stay.
Mechanism mechanism_in_interval(const Mechanism& mechanism, const PayloadIntervals& stretches, int stretch);

/// The same at a time; at a switch as it is from then on.
Mechanism mechanism_at_time(const Mechanism& mechanism, double time);

/// Which of the payloads that come or go are there at a time, a sentence each.
std::vector<std::string> list_payload_notes(const Mechanism& mechanism, double time);

}  // namespace balance
