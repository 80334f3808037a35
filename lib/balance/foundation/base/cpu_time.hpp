#pragma once
/// CPU time of this thread, which does not depend on the load of the machine, and deadlines in terms of it.

#include <ctime>
#include <functional>
#include <stdexcept>
#include <utility>

namespace balance {

/// CPU time of this thread [s] since an arbitrary origin.
inline double thread_cpu_time() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Thrown by long computations at the deadline or when their result is no longer wanted.
class DeadlineExceeded : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// While it exists, motion computations of this thread throw DeadlineExceeded after `seconds` of CPU time or once
/// `stop` returns true. Nested deadlines all apply.
class Deadline {
 public:
  /// @param stop polled a few dozen times per second
  explicit Deadline(double seconds, std::function<bool()> stop = {})
      : outer_(innermost_), end_time_(thread_cpu_time() + seconds), stop_(std::move(stop)) {
    innermost_ = this;
  }
  ~Deadline() { innermost_ = outer_; }
  Deadline(const Deadline&) = delete;
  Deadline& operator=(const Deadline&) = delete;

  /// Call every few microseconds.
  static void check() {
    if (innermost_ == nullptr || ++call_count_ % calls_per_clock_read != 0) return;
    const double now = thread_cpu_time();
    for (Deadline* deadline = innermost_; deadline != nullptr; deadline = deadline->outer_)
      if (now >= deadline->end_time_ || deadline->is_stopped(now))
        throw DeadlineExceeded("the time ran out while a motion was computed");
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
