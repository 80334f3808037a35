#include "cli/signals.hpp"

#include "cli/failures.hpp"

#include <unistd.h>

#include <csignal>
#include <cstring>
#include <initializer_list>

namespace balance::app {
namespace {

constexpr const char* interrupted_message = "interrupted";

// A signal handler can only reach globals.
volatile std::sig_atomic_t deferred = 0;
volatile std::sig_atomic_t pending = 0;
volatile std::sig_atomic_t interrupt_guard_active = 0;
const char* volatile interrupt_message = nothing_written_message;

/// Clears the progress line first. A handler may call only async-signal-safe functions: no stdio.
void write_interrupt_message() {
  constexpr char wipe[] = "\r\033[K";
  const char* const text = interrupt_message;
  if (::isatty(STDERR_FILENO) == 1 && ::write(STDERR_FILENO, wipe, sizeof wipe - 1) < 0) return;
  if (::write(STDERR_FILENO, text, std::strlen(text)) < 0 || ::write(STDERR_FILENO, "\n", 1) < 0) return;
}

extern "C" void handle_signal(int signal) {
  const bool first_interrupt = interrupt_guard_active != 0 && signal == SIGINT && pending == 0;
  if (deferred == 0 && !first_interrupt) {
    write_interrupt_message();
    _exit(static_cast<int>(ExitCode::signal) + signal);
  }
  pending = signal;
}

}  // namespace

void install_signal_handlers() {
  // Exceeding the file size limit becomes a write error, which can be reported, instead of killing the process.
  std::signal(SIGXFSZ, SIG_IGN);
  // If the parent process ignores SIGCHLD, we inherit that and cannot wait for the exit status of a child.
  std::signal(SIGCHLD, SIG_DFL);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction action {};
    if (sigaction(signal, nullptr, &action) != 0 || action.sa_handler == SIG_IGN) continue;
    action = {};
    action.sa_handler = handle_signal;
    action.sa_flags = SA_RESTART;
    sigaction(signal, &action, nullptr);
  }
}

int pending_signal() { return pending; }

SignalDeferral::SignalDeferral() { deferred = 1; }

SignalDeferral::~SignalDeferral() {
  deferred = 0;
  if (pending == 0) interrupt_message = interrupted_message;
}

void set_interrupt_message(const char* text) { interrupt_message = text; }

InterruptGuard::InterruptGuard() { interrupt_guard_active = 1; }

InterruptGuard::~InterruptGuard() {
  interrupt_guard_active = 0;
  pending = 0;
}

bool InterruptGuard::was_interrupted() const { return pending != 0; }

}  // namespace balance::app
