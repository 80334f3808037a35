#pragma once
/// Work in processes of its own: it may crash, hang or eat memory, and nobody else is harmed.

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

struct pollfd;

namespace balance {

/// What fenced work may use.
struct WorkerLimits {
  double wall_seconds = 0;          ///< for one task, by the clock on the wall; 0: as many as it likes
  std::uintmax_t memory_bytes = 0;  ///< of memory, beyond what its parent had when it began; 0: as much as there is
};

enum class WorkerState {
  idle,           ///< it has no task, or has done it: its text is there
  busy,           ///< it has a task
  crashed,        ///< a signal ended it, or it left without a text
  timed_out,      ///< it was ended because its task took longer than allowed
  out_of_memory,  ///< its task asked for more memory than allowed
};

/// A child process that does one task after the other, each of which comes to a text. It ends when this object does, or this
/// process, however that comes. One that is neither idle nor busy has ended.
class SandboxedWorker {
 public:
  using Work = std::function<std::string(std::size_t task)>;

  /// Starts it, idle. The child is a copy of this thread alone: where other threads run, `work` must need no lock that they may
  /// hold, but for the turn with HDF5. @throws SystemError if the system has no process left
  SandboxedWorker(const Work& work, const WorkerLimits& limits);
  ~SandboxedWorker();
  SandboxedWorker(const SandboxedWorker&) = delete;
  SandboxedWorker& operator=(const SandboxedWorker&) = delete;

  /// Gives a task to a worker that is idle.
  void submit(std::size_t task);

  /// Appends what wakes a poll when there is something to look at, and shortens the time to wait.
  void add_poll_events(std::vector<pollfd>& events, std::chrono::milliseconds& wait) const;

  /// Takes what has come.
  WorkerState update_state();

  std::size_t task_count() const { return tasks_; }      ///< that it was given so far
  const std::string& reply() const { return text_; }     ///< of the task that is done
  const std::string& reason() const { return reason_; }  ///< after `crashed`: "SIGSEGV", "exit code 1 without a result"

 private:
  using Clock = std::chrono::steady_clock;

  void drain();
  bool take_reply();
  bool reap(int options);
  void kill();
  WorkerState classify_exit(int status);

  const WorkerLimits limits_;
  Clock::time_point deadline_ = Clock::time_point::max();
  int child_ = -1, socket_ = -1;
  int pidfd_ = -1;  ///< becomes readable when the child ends; -1 where the system has no such thing
  WorkerState state_ = WorkerState::idle;
  std::size_t tasks_ = 0;
  std::string incoming_, text_, reason_;
};

/// Waits until one of them may have done its task or ended, or a limit has passed.
/// @param most how long at most
void wait_for_any(const std::vector<const SandboxedWorker*>& all,
                  std::chrono::milliseconds most = std::chrono::minutes(1));

}  // namespace balance
