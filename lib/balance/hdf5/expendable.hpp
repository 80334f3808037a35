#pragma once
/// Doing something dangerous in a copy of this process.

#include <cstdint>
#include <functional>

namespace balance {

/// What the copy may use.
struct ExpendableLimits {
  std::uintmax_t seconds = 1;  ///< of the processor
  std::uintmax_t bytes = 0;    ///< of memory, besides what this process has now
};

/// A child process with a line to it. It prints nothing, writes no file, has none of the descriptors of this process, and may crash, hang
/// or use too much memory: the line then ends. It is gone, at the latest, when this is.
class Expendable {
 public:
  /// @param work runs in the child, with the child's end of the line; it must need no lock that another thread may hold
  /// @throws std::system_error if the system has no process or line left
  Expendable(const std::function<void(int)>& work, const ExpendableLimits& limits);
  ~Expendable();
  Expendable(const Expendable&) = delete;
  Expendable& operator=(const Expendable&) = delete;

  /// This process's end: a connected socket.
  int line() const { return line_; }

 private:
  int line_ = -1;
  int child_ = -1;
};

/// From here on this process opens no file any more; those that are open stay.
void open_no_more_files();

}  // namespace balance
