#include "patience.hpp"

#include "native.hpp"

#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace balance::python {
namespace {

using namespace std::chrono_literals;

/// What the thread that works and the one that waits both know.
struct Shared {
  Errand errand;
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
    const py::gil_scoped_release free;
    std::unique_lock lock(mutex);
    return ended.wait_for(lock, time, [this] { return done; });
  }
};

struct LeftBehind {
  std::thread thread;
  std::shared_ptr<Shared> shared;
};

/// Threads whose callers were interrupted. The process must not end under them. Guarded by the interpreter's lock.
std::vector<LeftBehind>& left_behind() {
  static std::vector<LeftBehind> all;
  return all;
}

/// Work that can be asked to end does so at once.
void leave(std::thread thread, std::shared_ptr<Shared> shared, Leaving leaving) {
  shared->errand.abandon();
  if (leaving == Leaving::never || shared->wait(1s)) {
    const py::gil_scoped_release free;
    thread.join();
    return;
  }
  left_behind().push_back({std::move(thread), std::move(shared)});
}

/// At the end of the interpreter. Whoever presses Ctrl-C once more does not want to wait for it.
void join_left_behind() {
  for (LeftBehind& one : left_behind()) {
    while (!one.shared->wait(50ms))
      if (PyErr_CheckSignals() != 0) std::_Exit(130);
    one.thread.join();
  }
  left_behind().clear();
}

/// @return whether the caller still wants it; else Python's error is set
bool look_up(Errand& errand, const py::object& progress, double& told) {
  if (PyErr_CheckSignals() != 0) return false;
  const double part = errand.part();
  if (progress.is_none() || part == told) return true;
  try {
    progress(told = part);
  } catch (py::error_already_set& error) {
    error.restore();
    return false;
  }
  return true;
}

}  // namespace

void run_patiently(std::function<void(Errand&)> work, const py::object& progress, Leaving leaving) {
  auto shared = std::make_shared<Shared>();
  std::thread thread([shared, work = std::move(work)]() mutable {
    try {
      work(shared->errand);
    } catch (...) {
      shared->trouble = std::current_exception();
    }
    work = nullptr;  // what it holds is gone before anybody goes on
    shared->finish();
  });
  double told = 0;
  while (!shared->wait(50ms)) {
    if (look_up(shared->errand, progress, told)) continue;
    const py::error_already_set error;
    leave(std::move(thread), std::move(shared), leaving);
    throw error;
  }
  thread.join();
  if (shared->trouble) std::rethrow_exception(shared->trouble);
}

void bind_patience(py::module_& m) {
  m.def("_join_left_behind", &join_left_behind, "Waits for work whose callers were interrupted.");
  py::module_::import("atexit").attr("register")(m.attr("_join_left_behind"));
}

}  // namespace balance::python
