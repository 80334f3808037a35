#pragma once
/// Work that may take long is done in a thread of its own while the caller's waits without the interpreter's lock, looks for Ctrl-C, and
/// tells how far it has come. Interrupted work is asked to end; what cannot be asked is left to end by itself.

#include <pybind11/pybind11.h>

#include <atomic>
#include <functional>
#include <memory>
#include <optional>

namespace balance::python {

namespace py = pybind11;

/// The caller's thread gives the interpreter's lock away for as long as this lives. The interpreter may end meanwhile: it does not wait for
/// daemon threads, and ends those that ask for its lock by unwinding their stack, which no destructor survives. Such a thread stays where
/// it is until the process ends.
class ScopedGilRelease {
 public:
  ScopedGilRelease();
  ~ScopedGilRelease();
  ScopedGilRelease(const ScopedGilRelease&) = delete;
  ScopedGilRelease& operator=(const ScopedGilRelease&) = delete;

 private:
  PyThreadState* state_;
};

/// Nobody waits for the work any more.
struct TaskCancelled {};

/// What work says and asks while it goes on.
class BackgroundTask {
 public:
  bool is_cancelled() const { return abandoned_; }
  /// @param part that is done, 0 … 1 @throws Abandoned
  void report_progress(double part) {
    set_progress(part);
    if (abandoned_) throw TaskCancelled();
  }
  /// The same where nothing may be thrown.
  void set_progress(double part) { part_ = part; }
  void abandon() { abandoned_ = true; }
  double part() const { return part_; }

 private:
  std::atomic<bool> abandoned_ = false;
  std::atomic<double> part_ = 0;
};

/// Whether interrupted work may outlive the call. `never` is for work that ends soon when it is asked to.
enum class DetachPolicy { allowed, never };

/// @param work owns what it works on, unless it never is left, and knows nothing of Python
/// @param progress None, or what is called with the part that is done, now and then
/// @throws whatever the work throws; KeyboardInterrupt; what `progress` raises
void run_in_background(std::function<void(BackgroundTask&)> work, const py::object& progress,
                       DetachPolicy leaving = DetachPolicy::allowed);

/// The same for work that comes to a value.
template <class Work>
auto compute_in_background(Work work, const py::object& progress = py::none(),
                           DetachPolicy leaving = DetachPolicy::allowed) {
  using Value = decltype(work(std::declval<BackgroundTask&>()));
  auto value = std::make_shared<std::optional<Value>>();
  run_in_background([value, work = std::move(work)](BackgroundTask& errand) { value->emplace(work(errand)); }, progress,
                    leaving);
  return std::move(**value);
}

}  // namespace balance::python
