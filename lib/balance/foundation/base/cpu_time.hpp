#pragma once
/// Time that this thread has computed for, which does not depend on what else the machine does, and when it is to end.

#include <ctime>
#include <functional>
#include <stdexcept>
#include <utility>

namespace balance {

/// [s] since some moment.
inline double thread_cpu_time() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Thrown by long computations at the deadline, or when nobody wants them any more.
class DeadlineExceeded : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// While it lives, motions that this thread follows end with DeadlineExceeded after so many seconds of computing, or when `stop` says so.
/// Deadlines within each other all count.
class Deadline {
 public:
  /// @param stop asked a few dozen times a second
  explicit Deadline(double seconds, std::function<bool()> stop = {})
      : outer_(innermost_), end_time_(thread_cpu_time() + seconds), stop_(std::move(stop)) {
    innermost_ = this;
  }
  ~Deadline() { innermost_ = outer_; }
  Deadline(const Deadline&) = delete;
  Deadline& operator=(const Deadline&) = delete;

  /// To be called every few microseconds.
  static void check() {
    if (innermost_ == nullptr || ++call_count_ % calls_per_clock_read != 0) return;
    const double now = thread_cpu_time();
    for (Deadline* one = innermost_; one != nullptr; one = one->outer_)
      if (now >= one->end_time_ || one->is_stopped(now))
        throw DeadlineExceeded("the time ran out while a motion was followed");
  }

 private:
  static constexpr unsigned calls_per_clock_read = 16;
  static constexpr double stop_poll_interval = 0.03;

  bool is_stopped(double now) {
    if (!stop_ || now < next_poll_time_) return false;
    next_poll_time_ = now + stop_poll_interval;
    return stop_();
  }

  static inline thread_local Deadline* innermost_ = nullptr;
  static inline thread_local unsigned call_count_ = 0;
  Deadline* outer_;
  double end_time_, next_poll_time_ = 0;
  std::function<bool()> stop_;
};

}  // namespace balance
