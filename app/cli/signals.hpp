#pragma once
/// Ctrl-C and other termination signals. They end the program immediately with a message, except while a file is being
/// written: then the writer is asked to stop, so that it can remove the incomplete file.

#include <chrono>

namespace balance::app {

/// Installs the handlers for SIGINT, SIGTERM and SIGHUP. A signal that was ignored at program start stays ignored.
void install_signal_handlers();

inline constexpr const char* nothing_written_message = "interrupted, nothing written";

/// Sets the message printed when a signal ends the program; initially `nothing_written_message`. @param text must stay
/// valid
void set_interrupt_message(const char* text);

/// The pending signal, recorded while signals were deferred; 0 if none.
int pending_signal();

/// Defers signals: during its lifetime they are only recorded. After its destruction the message no longer says that
/// nothing was written. Not to be nested.
class SignalDeferral {
 public:
  SignalDeferral();
  ~SignalDeferral();
  SignalDeferral(const SignalDeferral&) = delete;
  SignalDeferral& operator=(const SignalDeferral&) = delete;
};

/// During its lifetime, the first Ctrl-C is only recorded; a second one, or any other signal, ends the program. Not to
/// be nested, nor combined with SignalDeferral.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();  ///< clears the recorded signal
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;
  bool was_interrupted() const;
};

/// Wall-clock time since construction.
class Stopwatch {
 public:
  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace balance::app
