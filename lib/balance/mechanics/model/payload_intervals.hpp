#pragma once
/// Intervals of a motion between the times at which payloads are taken up or set down (AttachmentOf::from, until).

#include "balance/mechanics/model/mechanism.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace balance::model {

/// Whether its mass moves with its body only part of the time.
template <class T>
bool is_temporary_payload(const AttachmentOf<T>& attachment) {
  return std::isfinite(attachment.from) || std::isfinite(attachment.until);
}

template <class T>
bool has_temporary_payloads(const MechanismOf<T>& mechanism) {
  return std::any_of(mechanism.attachments.begin(), mechanism.attachments.end(),
                     [](const AttachmentOf<T>& attachment) { return is_temporary_payload(attachment); });
}

/// All times at which payloads are taken up or set down, unsorted and with repetitions [s].
template <class T>
std::vector<double> payload_switch_times(const MechanismOf<T>& mechanism) {
  std::vector<double> times;
  for (const AttachmentOf<T>& attachment : mechanism.attachments)
    for (const double time : {attachment.from, attachment.until})
      if (std::isfinite(time)) times.push_back(time);
  return times;
}

/// The intervals of a motion within which no payload is taken up or set down.
class PayloadIntervals {
 public:
  /// One interval, in which all payloads are attached.
  PayloadIntervals() = default;
  /// @param duration duration of the motion, which starts at time 0 [s]
  template <class T>
  PayloadIntervals(const MechanismOf<T>& mechanism, double duration) : duration_(duration) {
    for (const AttachmentOf<T>& attachment : mechanism.attachments)
      presence_.emplace_back(attachment.from, attachment.until);
    find_switch_times(payload_switch_times(mechanism));
  }

  /// Times strictly inside the motion at which a payload is taken up or set down, increasing [s].
  const std::vector<double>& switch_times() const { return switches_; }
  int count() const { return static_cast<int>(switches_.size()) + 1; }
  /// The interval that contains a time. A switch time belongs to the interval that starts there.
  int index_at(double time) const;
  /// @param attachment index into Mechanism::attachments
  bool is_attached(std::size_t attachment, int interval) const;

 private:
  void find_switch_times(std::vector<double> times);

  double duration_ = 1;
  std::vector<std::pair<double, double>> presence_;  ///< per attachment: from, until
  std::vector<double> switches_;
};

/// Removes the mass; name and index stay.
void detach(Attachment& attachment);

/// The mechanism during one interval: detached payloads have no mass, and all attachments are permanent. Bodies, names
/// and indices do not change.
Mechanism mechanism_in_interval(const Mechanism& mechanism, const PayloadIntervals& intervals, int interval);

/// The mechanism at a time; at a switch time, just after the switch.
Mechanism mechanism_at_time(const Mechanism& mechanism, double time);

/// One sentence for each temporary payload: whether it is attached at a time.
std::vector<std::string> list_payload_notes(const Mechanism& mechanism, double time);

}  // namespace balance::model
