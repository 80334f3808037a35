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
class WithoutLock {
 public:
  WithoutLock();
  ~WithoutLock();
  WithoutLock(const WithoutLock&) = delete;
  WithoutLock& operator=(const WithoutLock&) = delete;

 private:
  PyThreadState* state_;
};

/// Nobody waits for the work any more.
struct Abandoned {};

/// What work says and asks while it goes on.
class Errand {
 public:
  bool is_abandoned() const { return abandoned_; }
  /// @param part that is done, 0 … 1 @throws Abandoned
  void tell(double part) {
    note(part);
    if (abandoned_) throw Abandoned();
  }
  /// The same where nothing may be thrown.
  void note(double part) { part_ = part; }
  void abandon() { abandoned_ = true; }
  double part() const { return part_; }

 private:
  std::atomic<bool> abandoned_ = false;
  std::atomic<double> part_ = 0;
};

/// Whether interrupted work may outlive the call. `never` is for work that ends soon when it is asked to.
enum class Leaving { allowed, never };

/// @param work owns what it works on, unless it never is left, and knows nothing of Python
/// @param progress None, or what is called with the part that is done, now and then
/// @throws whatever the work throws; KeyboardInterrupt; what `progress` raises
void run_patiently(std::function<void(Errand&)> work, const py::object& progress, Leaving leaving = Leaving::allowed);

/// The same for work that comes to a value.
template <class Work>
auto patiently(Work work, const py::object& progress = py::none(), Leaving leaving = Leaving::allowed) {
  using Value = decltype(work(std::declval<Errand&>()));
  auto value = std::make_shared<std::optional<Value>>();
  run_patiently([value, work = std::move(work)](Errand& errand) { value->emplace(work(errand)); }, progress, leaving);
  return std::move(**value);
}

}  // namespace balance::python
