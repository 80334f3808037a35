#include "balance/interface/batch/sandboxed_worker.hpp"

#include "balance/foundation/base/error.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <system_error>

namespace balance::batch {
namespace {

using hdf5::ChannelError;
using hdf5::Message;
using hdf5::MessageChannel;

constexpr std::size_t task_bytes = sizeof(std::uint64_t);

/// Performs tasks until the parent closes the connection.
void serve(const SandboxedWorker::Work& work, int socket) {
  const MessageChannel parent(socket);
  for (;;) {
    Message task;
    try {
      task = parent.receive(task_bytes);
    } catch (const ChannelError&) {
      return;
    }
    parent.send(Message(work(static_cast<std::size_t>(task.read_number()))));
  }
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
  try {
    process_.emplace([&](int socket) { serve(work, socket); }, hdf5::SandboxLimits{.memory_bytes = limits.memory_bytes},
                     hdf5::SandboxAccess::files);
  } catch (const std::system_error& error) {
    throw SystemError(fmt::format("cannot start a process: {}", error.code().message()));
  }
  pidfd_ = open_pidfd(process_->process_id());
}

SandboxedWorker::~SandboxedWorker() {
  if (state_ == WorkerState::idle) process_->finish();
  if (pidfd_ >= 0) ::close(pidfd_);
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
  Message message;
  message.write(std::uint64_t{task});
  try {
    MessageChannel(process_->socket()).send(message);
  } catch (const ChannelError&) {  // the child has died meanwhile: the next update_state() notices
  }
}

void SandboxedWorker::add_poll_events(std::vector<pollfd>& events, std::chrono::milliseconds& wait) const {
  using std::chrono::milliseconds;
  if (is_connected_) events.push_back({process_->socket(), POLLIN, 0});
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
  while (is_connected_) {
    const ssize_t count = ::recv(process_->socket(), buffer, sizeof buffer, MSG_DONTWAIT);
    if (count > 0) {
      receive_buffer_.append(buffer, static_cast<std::size_t>(count));
      continue;
    }
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && errno == EAGAIN) return;
    is_connected_ = false;
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
  if (code == hdf5::exit_out_of_memory) return WorkerState::out_of_memory;
  reason_ = WIFSIGNALED(status) ? name_of_signal(WTERMSIG(status)) : fmt::format("exit code {} without a result", code);
  return WorkerState::crashed;
}

WorkerState SandboxedWorker::update_state() {
  if (state_ != WorkerState::busy) return state_;
  drain();
  if (take_reply()) return state_;
  if (const std::optional<int> status = process_->find_exit_status()) return state_ = classify_exit(*status);
  if (Clock::now() < deadline_) return state_;
  process_.reset();
  is_connected_ = false;
  return state_ = WorkerState::timed_out;
}

void wait_for_any(const std::vector<const SandboxedWorker*>& workers, std::chrono::milliseconds max_wait) {
  std::vector<pollfd> events;
  std::chrono::milliseconds wait = max_wait;
  for (const SandboxedWorker* worker : workers) worker->add_poll_events(events, wait);
  ::poll(events.data(), events.size(), static_cast<int>(wait.count()));
}

}  // namespace balance::batch
