#pragma once
/// Runs long computations in a separate thread. Meanwhile, the calling thread releases the GIL, checks for Ctrl-C and
/// reports progress. Interrupted work is asked to stop; work that does not stop soon is detached.

#include <pybind11/pybind11.h>

#include <atomic>
#include <functional>
#include <memory>
#include <optional>

namespace balance::python {

namespace py = pybind11;

/// Releases the GIL during its lifetime. The interpreter may be finalized meanwhile: it does not wait for daemon
/// threads, and ends those that request the GIL by unwinding their stack, which terminates the process if it passes a
/// destructor. Such a thread is suspended until the process exits.
class ScopedGilRelease {
 public:
  ScopedGilRelease();
  ~ScopedGilRelease();
  ScopedGilRelease(const ScopedGilRelease&) = delete;
  ScopedGilRelease& operator=(const ScopedGilRelease&) = delete;

 private:
  PyThreadState* state_;
};

/// Thrown when the caller no longer waits for the result.
struct TaskCancelled {};

/// The communication between the work and its caller.
class BackgroundTask {
 public:
  bool is_cancelled() const { return is_cancelled_; }
  /// @param fraction completed fraction, 0 … 1 @throws TaskCancelled
  void report_progress(double fraction) {
    set_progress(fraction);
    if (is_cancelled_) throw TaskCancelled();
  }
  /// The same for code that must not throw.
  void set_progress(double fraction) { fraction_ = fraction; }
  void abandon() { is_cancelled_ = true; }
  double part() const { return fraction_; }

 private:
  std::atomic<bool> is_cancelled_ = false;
  std::atomic<double> fraction_ = 0;
};

/// Whether interrupted work may outlive the call. `never` is for work that stops promptly when asked to.
enum class DetachPolicy { allowed, never };

/// @param work must not use Python, and must own its data unless `detach_policy` is `never`
/// @param progress None, or a callback that is called with the completed fraction from time to time
/// @throws any exception of `work`; KeyboardInterrupt; any exception of `progress`
void run_in_background(std::function<void(BackgroundTask&)> work, const py::object& progress,
                       DetachPolicy detach_policy = DetachPolicy::allowed);

/// The same for work that returns a value.
template <class Work>
auto compute_in_background(Work work, const py::object& progress = py::none(),
                           DetachPolicy detach_policy = DetachPolicy::allowed) {
  using Value = decltype(work(std::declval<BackgroundTask&>()));
  auto value = std::make_shared<std::optional<Value>>();
  run_in_background([value, work = std::move(work)](BackgroundTask& task) { value->emplace(work(task)); }, progress,
                    detach_policy);
  return std::move(**value);
}

}  // namespace balance::python
