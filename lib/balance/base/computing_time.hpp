#pragma once
/// Time that this thread has computed for, which does not depend on what else the machine does, and when it is to end.

#include <ctime>
#include <functional>
#include <stdexcept>
#include <utility>

namespace balance {

/// [s] since some moment.
inline double computing_time() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Thrown by long computations at the deadline, or when nobody wants them any more.
class OutOfTime : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// While it lives, motions that this thread follows end with OutOfTime after so many seconds of computing, or when `stop` says so. Deadlines
/// within each other all count.
class Deadline {
 public:
  /// @param stop asked a few dozen times a second
  explicit Deadline(double seconds, std::function<bool()> stop = {})
      : outer_(innermost_), end_(computing_time() + seconds), stop_(std::move(stop)) {
    innermost_ = this;
  }
  ~Deadline() { innermost_ = outer_; }
  Deadline(const Deadline&) = delete;
  Deadline& operator=(const Deadline&) = delete;

  /// To be called every few microseconds.
  static void check() {
    if (innermost_ == nullptr || ++calls_ % calls_per_look != 0) return;
    const double now = computing_time();
    for (Deadline* one = innermost_; one != nullptr; one = one->outer_)
      if (now >= one->end_ || one->is_stopped(now)) throw OutOfTime("the time ran out while a motion was followed");
  }

 private:
  static constexpr unsigned calls_per_look = 16;
  static constexpr double seconds_per_question = 0.03;

  bool is_stopped(double now) {
    if (!stop_ || now < next_question_) return false;
    next_question_ = now + seconds_per_question;
    return stop_();
  }

  static inline thread_local Deadline* innermost_ = nullptr;
  static inline thread_local unsigned calls_ = 0;
  Deadline* outer_;
  double end_, next_question_ = 0;
  std::function<bool()> stop_;
};

}  // namespace balance
