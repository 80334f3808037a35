#pragma once
/// Time that this thread has computed for: a budget in it does not depend on what else the machine does. Private to design.

#include <ctime>

namespace balance::designing {

/// [s] since some moment.
inline double computing_time() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace balance::designing
