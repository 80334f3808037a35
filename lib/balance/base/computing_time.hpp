#pragma once
/// Time that this thread has computed for, which does not depend on what else the machine does, and when it is to end.

#include <algorithm>
#include <ctime>
#include <limits>
#include <stdexcept>

namespace balance {

/// [s] since some moment.
inline double computing_time() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Thrown by long computations at the deadline.
class OutOfTime : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// While it lives, motions that this thread follows end with OutOfTime after so many seconds of computing. Of deadlines within each other
/// the earliest counts.
class Deadline {
 public:
  explicit Deadline(double seconds) : outer_(end_) { end_ = std::min(end_, computing_time() + seconds); }
  ~Deadline() { end_ = outer_; }
  Deadline(const Deadline&) = delete;
  Deadline& operator=(const Deadline&) = delete;

  static void check() {
    if (end_ < std::numeric_limits<double>::infinity() && computing_time() >= end_)
      throw OutOfTime("the time ran out while a motion was followed");
  }

 private:
  static inline thread_local double end_ = std::numeric_limits<double>::infinity();
  double outer_;
};

}  // namespace balance
