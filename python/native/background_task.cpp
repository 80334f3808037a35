#include "background_task.hpp"

#include "bindings.hpp"

#include "balance/foundation/base/cpu_time.hpp"

#include <cxxabi.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <exception>
#include <limits>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace balance::python {
namespace {

using namespace std::chrono_literals;

std::atomic<std::thread::id> finalizing_thread;  ///< thread that finalizes the interpreter; default: not finalizing
std::atomic<int> released_call_count = 0;

[[noreturn]] void wait_forever() {
  while (true) ::pause();
}

/// Then the result of this thread is no longer needed, and the objects it would use are being destroyed.
bool is_interpreter_finalizing() {
  const std::thread::id ending = finalizing_thread;
  return ending != std::thread::id() && ending != std::this_thread::get_id();
}

/// State shared by the working and the waiting thread.
struct TaskState {
  BackgroundTask task;
  std::mutex mutex;
  std::condition_variable ended;
  bool done = false;
  std::exception_ptr exception;

  void finish() {
    const std::lock_guard lock(mutex);
    done = true;
    ended.notify_all();
  }
  /// Waits without the GIL. @return whether the work is done
  bool wait(std::chrono::milliseconds time) {
    const ScopedGilRelease free;
    std::unique_lock lock(mutex);
    return ended.wait_for(lock, time, [this] { return done; });
  }
};

struct DetachedThread {
  std::thread thread;
  std::shared_ptr<TaskState> shared;
};

/// Tasks that a caller waits for. Guarded by the GIL.
std::vector<std::shared_ptr<TaskState>>& running_tasks() {
  static std::vector<std::shared_ptr<TaskState>> all;
  return all;
}

/// Threads whose callers were interrupted; they must end before the process exits. Guarded by the GIL.
std::vector<DetachedThread>& detached_threads() {
  static std::vector<DetachedThread> all;
  return all;
}

/// Waits for cancelled work that stops promptly, and otherwise detaches the thread.
void join_or_detach(std::thread thread, std::shared_ptr<TaskState> shared, DetachPolicy detach_policy) {
  shared->task.abandon();
  if (detach_policy == DetachPolicy::never || shared->wait(1s)) {
    const ScopedGilRelease free;
    thread.join();
    return;
  }
  detached_threads().push_back({std::move(thread), std::move(shared)});
}

void wait_for(TaskState& state) {
  while (!state.wait(50ms))
    if (PyErr_CheckSignals() != 0) std::_Exit(130);
}

/// Runs when the interpreter exits. A further Ctrl-C ends the process without waiting.
void join_detached_threads() {
  finalizing_thread = std::this_thread::get_id();
  const std::vector<std::shared_ptr<TaskState>> states =
      running_tasks();  // called by daemon threads, which the interpreter does not wait for
  for (const auto& state : states) state->task.abandon();
  for (const auto& state : states) wait_for(*state);
  while (released_call_count > 0) {
    const py::gil_scoped_release free;
    std::this_thread::sleep_for(1ms);
  }
  for (DetachedThread& one : detached_threads()) {
    wait_for(*one.shared);
    one.thread.join();
  }
  detached_threads().clear();
}

/// @return whether the caller still waits; if false, the Python error is set
bool poll_interpreter(BackgroundTask& task, const py::object& progress, double& reported) try {
  if (PyErr_CheckSignals() != 0) return false;
  const double fraction = task.part();
  if (progress.is_none() || fraction == reported) return true;
  try {
    progress(reported = fraction);
  } catch (py::error_already_set& error) {
    error.restore();
    return false;
  }
  return true;
} catch (abi::__forced_unwind&) {
  wait_forever();  // the interpreter was finalized while it ran Python code
}

}  // namespace

ScopedGilRelease::ScopedGilRelease() : state_(PyEval_SaveThread()) {
  ++released_call_count;
  if (!is_interpreter_finalizing()) return;
  --released_call_count;
  wait_forever();
}

ScopedGilRelease::~ScopedGilRelease() {
  --released_call_count;
  if (is_interpreter_finalizing()) wait_forever();
  try {
    PyEval_RestoreThread(state_);
  } catch (abi::__forced_unwind&) {
    wait_forever();
  }
}

void run_in_background(std::function<void(BackgroundTask&)> work, const py::object& progress,
                       DetachPolicy detach_policy) {
  auto shared = std::make_shared<TaskState>();
  std::thread thread([shared, work = std::move(work)]() mutable {
    try {
      const Deadline deadline(std::numeric_limits<double>::infinity(), [&] { return shared->task.is_cancelled(); });
      work(shared->task);
    } catch (...) {
      shared->exception = std::current_exception();
    }
    work = nullptr;  // destroy its captures before the waiting thread continues
    shared->finish();
  });
  running_tasks().push_back(shared);
  double reported = 0;
  while (!shared->wait(50ms)) {
    if (poll_interpreter(shared->task, progress, reported)) continue;
    const py::error_already_set error;
    std::erase(running_tasks(), shared);
    join_or_detach(std::move(thread), std::move(shared), detach_policy);
    throw error;
  }
  std::erase(running_tasks(), shared);
  thread.join();
  if (shared->exception) std::rethrow_exception(shared->exception);
}

void bind_background_tasks(py::module_& m) {
  m.def("_join_left_behind", &join_detached_threads, "Waits for background work whose callers were interrupted.");
  py::module_::import("atexit").attr("register")(m.attr("_join_left_behind"));
}

}  // namespace balance::python
