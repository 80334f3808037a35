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

std::atomic<std::thread::id> finalizing_thread;  ///< that ends the interpreter; none: it goes on
std::atomic<int> released_call_count = 0;

[[noreturn]] void wait_forever() {
  while (true) ::pause();
}

/// Nobody will hear of what this thread finds, and what it would use is going.
bool is_interpreter_finalizing() {
  const std::thread::id ending = finalizing_thread;
  return ending != std::thread::id() && ending != std::this_thread::get_id();
}

/// What the thread that works and the one that waits both know.
struct TaskState {
  BackgroundTask errand;
  std::mutex mutex;
  std::condition_variable ended;
  bool done = false;
  std::exception_ptr trouble;

  void finish() {
    const std::lock_guard lock(mutex);
    done = true;
    ended.notify_all();
  }
  /// Without the interpreter's lock. @return whether it is done
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

/// Work whose callers wait. Guarded by the interpreter's lock.
std::vector<std::shared_ptr<TaskState>>& running_tasks() {
  static std::vector<std::shared_ptr<TaskState>> all;
  return all;
}

/// Threads whose callers were interrupted. The process must not end under them. Guarded by the interpreter's lock.
std::vector<DetachedThread>& left_behind() {
  static std::vector<DetachedThread> all;
  return all;
}

/// Work that can be asked to end does so at once.
void leave(std::thread thread, std::shared_ptr<TaskState> shared, DetachPolicy leaving) {
  shared->errand.abandon();
  if (leaving == DetachPolicy::never || shared->wait(1s)) {
    const ScopedGilRelease free;
    thread.join();
    return;
  }
  left_behind().push_back({std::move(thread), std::move(shared)});
}

void wait_for(TaskState& work) {
  while (!work.wait(50ms))
    if (PyErr_CheckSignals() != 0) std::_Exit(130);
}

/// At the end of the interpreter. Whoever presses Ctrl-C once more does not want to wait for it.
void join_left_behind() {
  finalizing_thread = std::this_thread::get_id();
  const std::vector<std::shared_ptr<TaskState>> works =
      running_tasks();  // daemon threads, which the interpreter does not wait for, called them
  for (const auto& work : works) work->errand.abandon();
  for (const auto& work : works) wait_for(*work);
  while (released_call_count > 0) {
    const py::gil_scoped_release free;
    std::this_thread::sleep_for(1ms);
  }
  for (DetachedThread& one : left_behind()) {
    wait_for(*one.shared);
    one.thread.join();
  }
  left_behind().clear();
}

/// @return whether the caller still wants it; else Python's error is set
bool poll_interpreter(BackgroundTask& errand, const py::object& progress, double& reported) try {
  if (PyErr_CheckSignals() != 0) return false;
  const double part = errand.part();
  if (progress.is_none() || part == reported) return true;
  try {
    progress(reported = part);
  } catch (py::error_already_set& error) {
    error.restore();
    return false;
  }
  return true;
} catch (abi::__forced_unwind&) {
  wait_forever();  // the interpreter has ended in Python's code
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

void run_in_background(std::function<void(BackgroundTask&)> work, const py::object& progress, DetachPolicy leaving) {
  auto shared = std::make_shared<TaskState>();
  std::thread thread([shared, work = std::move(work)]() mutable {
    try {
      const Deadline wanted(std::numeric_limits<double>::infinity(), [&] { return shared->errand.is_cancelled(); });
      work(shared->errand);
    } catch (...) {
      shared->trouble = std::current_exception();
    }
    work = nullptr;  // what it holds is gone before anybody goes on
    shared->finish();
  });
  running_tasks().push_back(shared);
  double reported = 0;
  while (!shared->wait(50ms)) {
    if (poll_interpreter(shared->errand, progress, reported)) continue;
    const py::error_already_set error;
    std::erase(running_tasks(), shared);
    leave(std::move(thread), std::move(shared), leaving);
    throw error;
  }
  std::erase(running_tasks(), shared);
  thread.join();
  if (shared->trouble) std::rethrow_exception(shared->trouble);
}

void bind_patience(py::module_& m) {
  m.def("_join_left_behind", &join_left_behind, "Waits for work whose callers were interrupted.");
  py::module_::import("atexit").attr("register")(m.attr("_join_left_behind"));
}

}  // namespace balance::python
