#include "balance/interface/batch/sandboxed_worker.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/hdf5/hdf5_lock.hpp"

#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <initializer_list>
#include <new>
#include <string_view>

#ifdef BALANCE_COVERAGE
extern "C" void __gcov_dump();
#endif

namespace balance::batch {
namespace {

constexpr int exit_out_of_memory = 86;  // exit codes of a child without a text
constexpr int exit_without_reply = 87;

/// Bytes of data that this process uses now.
[[maybe_unused]] std::uintmax_t data_segment_bytes() {
  std::uintmax_t pages = 0;
  if (std::FILE* file = std::fopen("/proc/self/statm", "re")) {
    if (std::fscanf(file, "%*u %*u %*u %*u %*u %ju", &pages) != 1) pages = 0;
    std::fclose(file);
  }
  return pages * static_cast<std::uintmax_t>(::sysconf(_SC_PAGESIZE));
}

/// Does nothing under sanitizers, whose shadow memory would count.
void limit_memory([[maybe_unused]] std::uintmax_t bytes) {
#ifndef BALANCE_SANITIZED
  struct rlimit limit {};
  if (bytes == 0 || ::getrlimit(RLIMIT_DATA, &limit) != 0) return;
  const std::uintmax_t used_bytes = data_segment_bytes();
  const std::uintmax_t max_bytes = bytes > UINTMAX_MAX / 2 ? bytes : used_bytes + bytes;
  limit.rlim_cur = std::min<std::uintmax_t>({max_bytes, limit.rlim_cur, limit.rlim_max});
  ::setrlimit(RLIMIT_DATA, &limit);
#endif
}

/// Moves the child to a process group of its own: signals from the keyboard reach only the parent, which decides, and
/// everything that the work starts ends with it. The child ends with the parent.
void setup_child(pid_t parent) {
  ::setpgid(0, 0);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT})
    std::signal(signal, SIG_DFL);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(exit_without_reply);  // the parent ended before we could ask for its signal
}

bool send_all(int to, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = ::send(to, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(sent));
  }
  return true;
}

/// A number in the form in which it is sent between parent and child.
std::string_view bytes_of(const std::uint64_t& number) {
  return {reinterpret_cast<const char*>(&number), sizeof number};
}

/// @return whether there is another task; the parent closes the connection if there is none
bool receive_task(int from, std::uint64_t& task) {
  ssize_t count = 0;
  do count = ::recv(from, &task, sizeof task, MSG_WAITALL);
  while (count < 0 && errno == EINTR);
  return count == static_cast<ssize_t>(sizeof task);
}

/// Exits without clean-up: buffers and temporary files belong to the parent.
[[noreturn]] void exit_child(int code) {
#ifdef BALANCE_COVERAGE
  __gcov_dump();
#endif
  ::_exit(code);
}

[[noreturn]] void run_in_child(const SandboxedWorker::Work& work, std::uintmax_t bytes, int parent) {
  limit_memory(bytes);
  try {
    for (std::uint64_t task = 0; receive_task(parent, task);) {
      const std::string reply = work(static_cast<std::size_t>(task));
      if (!send_all(parent, bytes_of(reply.size())) || !send_all(parent, reply)) exit_child(exit_without_reply);
    }
  } catch (const std::bad_alloc&) {
    exit_child(exit_out_of_memory);
  } catch (...) {
    exit_child(exit_without_reply);
  }
  exit_child(0);
}

std::string name_of_signal(int signal) {
  const char* const name = ::sigabbrev_np(signal);
  return name == nullptr ? fmt::format("signal {}", signal) : std::string("SIG") + name;
}

int open_pidfd(pid_t child) {
#ifdef SYS_pidfd_open
  return static_cast<int>(::syscall(SYS_pidfd_open, child, 0));
#else
  return -1;
#endif
}

}  // namespace

SandboxedWorker::SandboxedWorker(const Work& work, const WorkerLimits& limits) : limits_(limits) {
  int sockets[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, sockets) != 0)
    throw SystemError(fmt::format("cannot communicate with a process: {}", std::strerror(errno)));
  const pid_t parent = ::getpid();
  {
    const hdf5::Hdf5Lock lock;  // HDF5 is idle in the copy, too
    child_ = ::fork();
    if (child_ == 0) {
      hdf5::Hdf5Lock::reset_after_fork();
      setup_child(parent);
      ::close(sockets[0]);
      run_in_child(work, limits.memory_bytes, sockets[1]);
    }
  }
  const int error = errno;
  ::close(sockets[1]);
  socket_ = sockets[0];
  if (child_ < 0) {
    ::close(socket_);
    throw SystemError(fmt::format("cannot start a process: {}", std::strerror(error)));
  }
  ::setpgid(child_, child_);  // by parent or child, whichever runs first
  pidfd_ = open_pidfd(child_);
}

SandboxedWorker::~SandboxedWorker() {
  if (state_ == WorkerState::busy) kill();
  if (state_ == WorkerState::idle) {
    ::shutdown(socket_, SHUT_RDWR);  // closing is not enough: later children have copies
    reap(0);
  }
  for (const int descriptor : {socket_, pidfd_})
    if (descriptor >= 0) ::close(descriptor);
}

void SandboxedWorker::submit(std::size_t task) {
  ++task_count_;
  reply_.clear();
  receive_buffer_.clear();
  state_ = WorkerState::busy;
  deadline_ = Clock::time_point::max();
  if (limits_.wall_seconds > 0 && limits_.wall_seconds < 1e9)
    deadline_ =
        Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(limits_.wall_seconds));
  send_all(socket_, bytes_of(task));  // if the child has died meanwhile, the next update_state() notices
}

void SandboxedWorker::add_poll_events(std::vector<pollfd>& events, std::chrono::milliseconds& wait) const {
  using std::chrono::milliseconds;
  if (socket_ >= 0) events.push_back({socket_, POLLIN, 0});
  if (pidfd_ >= 0)
    events.push_back({pidfd_, POLLIN, 0});
  else
    wait = std::min(wait, milliseconds(5));
  if (deadline_ == Clock::time_point::max()) return;
  const auto remaining = std::chrono::ceil<milliseconds>(deadline_ - Clock::now());
  wait = std::clamp(remaining, milliseconds(0), wait);
}

void SandboxedWorker::drain() {
  char buffer[16384];
  while (socket_ >= 0) {
    const ssize_t count = ::recv(socket_, buffer, sizeof buffer, MSG_DONTWAIT);
    if (count > 0) {
      receive_buffer_.append(buffer, static_cast<std::size_t>(count));
      continue;
    }
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && errno == EAGAIN) return;
    ::close(socket_);
    socket_ = -1;
  }
}

/// @return whether the text of the task is complete
bool SandboxedWorker::take_reply() {
  std::uint64_t size = 0;
  if (receive_buffer_.size() < sizeof size) return false;
  std::memcpy(&size, receive_buffer_.data(), sizeof size);
  if (receive_buffer_.size() - sizeof size < size) return false;
  reply_ = receive_buffer_.substr(sizeof size, size);
  state_ = WorkerState::idle;
  return true;
}

WorkerState SandboxedWorker::classify_exit(int status) {
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : 0;
  if (code == exit_out_of_memory) return WorkerState::out_of_memory;
  reason_ = WIFSIGNALED(status) ? name_of_signal(WTERMSIG(status)) : fmt::format("exit code {} without a result", code);
  return WorkerState::crashed;
}

/// @return whether the child has ended
bool SandboxedWorker::reap(int options) {
  int status = 0;
  pid_t ended_child = 0;
  do ended_child = ::waitpid(child_, &status, options);
  while (ended_child < 0 && errno == EINTR);
  if (ended_child == 0) return false;
  state_ = classify_exit(status);
  return true;
}

void SandboxedWorker::kill() {
  ::kill(-child_, SIGKILL);
  ::kill(child_, SIGKILL);  // in case it has no group yet
  reap(0);
}

WorkerState SandboxedWorker::update_state() {
  if (state_ != WorkerState::busy) return state_;
  drain();
  if (take_reply() || reap(WNOHANG) || Clock::now() < deadline_) return state_;
  kill();
  return state_ = WorkerState::timed_out;
}

void wait_for_any(const std::vector<const SandboxedWorker*>& workers, std::chrono::milliseconds max_wait) {
  std::vector<pollfd> events;
  std::chrono::milliseconds wait = max_wait;
  for (const SandboxedWorker* worker : workers) worker->add_poll_events(events, wait);
  ::poll(events.data(), events.size(), static_cast<int>(wait.count()));
}

}  // namespace balance::batch
