#pragma once
/// Runs work in child processes, where it may crash, hang or exhaust memory without harming others.

#include "balance/foundation/hdf5/sandbox_process.hpp"

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

struct pollfd;

namespace balance::batch {

/// Resources that a worker may use.
struct WorkerLimits {
  double wall_seconds = 0;          ///< wall-clock time of one task; 0: no limit
  std::uintmax_t memory_bytes = 0;  ///< in addition to what its parent used when it started; 0: no limit
};

enum class WorkerState {
  idle,           ///< no task, or its task is done and reply() has the text
  busy,           ///< working on a task
  crashed,        ///< ended by a signal, or exited without a text
  timed_out,      ///< killed because its task took longer than allowed
  out_of_memory,  ///< its task requested more memory than allowed
};

/// A child process that performs one task after the other, each of which yields a text. It ends with this object. A
/// worker that is neither idle nor busy has ended.
class SandboxedWorker {
 public:
  using Work = std::function<std::string(std::size_t task)>;

  /// Starts the child, idle; see hdf5::SandboxProcess for what `work` may do.
  /// @throws SystemError if the system cannot create another process
  SandboxedWorker(const Work& work, const WorkerLimits& limits);
  ~SandboxedWorker();
  SandboxedWorker(const SandboxedWorker&) = delete;
  SandboxedWorker& operator=(const SandboxedWorker&) = delete;

  /// Assigns a task to an idle worker.
  void submit(std::size_t task);

  /// Appends the events that a poll must wait for, and shortens `wait` if necessary.
  void add_poll_events(std::vector<pollfd>& events, std::chrono::milliseconds& wait) const;

  /// Processes what has arrived from the child.
  WorkerState update_state();

  std::size_t task_count() const { return task_count_; }  ///< number of tasks submitted so far
  const std::string& reply() const { return reply_; }     ///< text of the completed task
  const std::string& reason() const { return reason_; }  ///< after `crashed`: "SIGSEGV", "exit code 1 without a result"

 private:
  using Clock = std::chrono::steady_clock;

  void drain();
  bool take_reply();
  WorkerState classify_exit(int status);

  const WorkerLimits limits_;
  Clock::time_point deadline_ = Clock::time_point::max();
  std::optional<hdf5::SandboxProcess> process_;
  bool is_connected_ = true;  ///< whether the child may send more
  int pidfd_ = -1;            ///< becomes readable when the child ends; -1 if the system has no pidfds
  WorkerState state_ = WorkerState::idle;
  std::size_t task_count_ = 0;
  std::string receive_buffer_, reply_, reason_;
};

/// Waits until a worker may have completed its task or ended, or a limit has passed.
/// @param max_wait maximum waiting time
void wait_for_any(const std::vector<const SandboxedWorker*>& workers,
                  std::chrono::milliseconds max_wait = std::chrono::minutes(1));

}  // namespace balance::batch
