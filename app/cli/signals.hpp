#pragma once
/// Ctrl-C and its relatives: they end the program at once, which says so, except while a file is written; then the writer is asked
/// to stop, so that it can remove what is unfinished.

#include <chrono>

namespace balance::app {

/// Installs the handlers for SIGINT, SIGTERM and SIGHUP; a signal that was ignored when the program started stays ignored.
void install_signal_handlers();

inline constexpr const char* nothing_written_message = "interrupted, nothing written";

/// What is said when a signal ends the program, in place of `nothing_written_message`. @param text stays where it is
void set_interrupt_message(const char* text);

/// The signal that arrived while signals were deferred; 0 if none did.
int pending_signal();

/// While it lives, signals only leave a mark; after it something may be written. Not to be nested.
class SignalDeferral {
 public:
  SignalDeferral();
  ~SignalDeferral();
  SignalDeferral(const SignalDeferral&) = delete;
  SignalDeferral& operator=(const SignalDeferral&) = delete;
};

/// While it lives, the first Ctrl-C only leaves a mark; the second one, and any other signal, ends the program. Not to be nested,
/// nor together with SignalDeferral.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();  ///< forgets the mark
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;
  bool was_interrupted() const;
};

/// Wall clock time since it was made.
class Stopwatch {
 public:
  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count(); }

 private:
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace balance::app
