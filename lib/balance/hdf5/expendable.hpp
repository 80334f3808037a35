#pragma once
/// Doing something dangerous in a copy of this process.

#include <cstdint>
#include <functional>

namespace balance {

/// What the copy may use.
struct SandboxLimits {
  std::uintmax_t cpu_seconds = 1;   ///< of the processor
  std::uintmax_t memory_bytes = 0;  ///< of memory, besides what this process has now
};

/// A child process with a line to it. It prints nothing, writes no file, has none of the descriptors of this process, and may crash, hang
/// or use too much memory: the line then ends. It is gone, at the latest, when this is.
class SandboxProcess {
 public:
  /// @param work runs in the child, with the child's end of the line; it must need no lock that another thread may hold
  /// @throws std::system_error if the system has no process or line left
  SandboxProcess(const std::function<void(int)>& work, const SandboxLimits& limits);
  ~SandboxProcess();
  SandboxProcess(const SandboxProcess&) = delete;
  SandboxProcess& operator=(const SandboxProcess&) = delete;

  /// This process's end: a connected socket.
  int socket() const { return line_; }

 private:
  int line_ = -1;
  int child_ = -1;
};

/// From here on this process opens no file any more; those that are open stay.
void forbid_opening_files();

}  // namespace balance
