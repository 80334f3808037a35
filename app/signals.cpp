#include "signals.hpp"

#include "exit_code.hpp"

#include <unistd.h>

#include <csignal>
#include <cstring>
#include <initializer_list>

namespace balance::app {
namespace {

constexpr const char* something_written = "interrupted";

// A signal handler can only reach globals.
volatile std::sig_atomic_t deferred = 0;
volatile std::sig_atomic_t pending = 0;
volatile std::sig_atomic_t awaited = 0;
const char* volatile words = nothing_written;

/// What is left of a progress line is wiped away. A handler may only call what is async-signal-safe: no stdio.
void tell_end() {
  constexpr char wipe[] = "\r\033[K";
  const char* const text = words;
  if (::isatty(STDERR_FILENO) == 1 && ::write(STDERR_FILENO, wipe, sizeof wipe - 1) < 0) return;
  if (::write(STDERR_FILENO, text, std::strlen(text)) < 0 || ::write(STDERR_FILENO, "\n", 1) < 0) return;
}

extern "C" void handle_signal(int signal) {
  const bool first_interrupt = awaited != 0 && signal == SIGINT && pending == 0;
  if (deferred == 0 && !first_interrupt) {
    tell_end();
    _exit(static_cast<int>(ExitCode::signal) + signal);
  }
  pending = signal;
}

}  // namespace

void install_signal_handlers() {
  // A file that may not grow is to be an error of write, which can be told, rather than the end.
  std::signal(SIGXFSZ, SIG_IGN);
  // Whoever started the program may ignore it, and then nobody could learn how a child ended.
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

DeferSignals::DeferSignals() { deferred = 1; }

DeferSignals::~DeferSignals() {
  deferred = 0;
  if (pending == 0) words = something_written;
}

void say_when_interrupted(const char* text) { words = text; }

AwaitInterrupt::AwaitInterrupt() { awaited = 1; }

AwaitInterrupt::~AwaitInterrupt() {
  awaited = 0;
  pending = 0;
}

bool AwaitInterrupt::came() const { return pending != 0; }

}  // namespace balance::app
