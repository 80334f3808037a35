#include "balance/foundation/hdf5/sandbox_process.hpp"

#include "balance/foundation/hdf5/hdf5_lock.hpp"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <initializer_list>
#include <new>
#include <system_error>

#ifdef BALANCE_COVERAGE
extern "C" void __gcov_dump();
#endif

namespace balance::hdf5 {

namespace {

constexpr int child_socket_descriptor = 3;

void set_resource_limit(int resource, std::uintmax_t max_value) {
  struct rlimit limit {};
  if (::getrlimit(static_cast<__rlimit_resource>(resource), &limit) != 0) return;
  const auto requested = static_cast<rlim_t>(max_value);
  limit.rlim_max = limit.rlim_max == RLIM_INFINITY ? requested : std::min(requested, limit.rlim_max);
  limit.rlim_cur = limit.rlim_max;
  ::setrlimit(static_cast<__rlimit_resource>(resource), &limit);
}

/// Bytes of data that this process uses now.
std::uintmax_t data_segment_bytes() {
  std::uintmax_t pages = 0;
  if (std::FILE* file = std::fopen("/proc/self/statm", "re")) {
    if (std::fscanf(file, "%*u %*u %*u %*u %*u %ju", &pages) != 1) pages = 0;
    std::fclose(file);
  }
  return pages * static_cast<std::uintmax_t>(::sysconf(_SC_PAGESIZE));
}

/// Keeps only the connection of the parent's descriptors; it becomes the first one after the standard ones.
void drop_access(int socket) {
  const int null_device = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  for (const int standard : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::dup2(null_device, standard);
  if (socket != child_socket_descriptor) ::dup2(socket, child_socket_descriptor);
  ::close_range(child_socket_descriptor + 1, ~0U, 0);
  ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  set_resource_limit(RLIMIT_CORE, 0);
  set_resource_limit(RLIMIT_FSIZE, 0);
}

void reset_signal_handlers() {
  for (const int signal : {SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT, SIGXCPU, SIGINT, SIGTERM, SIGHUP, SIGPIPE})
    std::signal(signal, SIG_DFL);
}

/// @param memory_bytes in all
void limit_resources(const SandboxLimits& limits, [[maybe_unused]] std::uintmax_t memory_bytes) {
  if (limits.cpu_seconds > 0) set_resource_limit(RLIMIT_CPU, limits.cpu_seconds);
#ifndef BALANCE_SANITIZED  // sanitizers use shadow memory, which counts
  if (limits.memory_bytes > 0) set_resource_limit(RLIMIT_DATA, memory_bytes);
#endif
}

/// Exits without clean-up: buffers and temporary files belong to the parent.
[[noreturn]] void run_and_exit(const std::function<void(int)>& work, int socket) {
  int code = 0;
  try {
    work(socket);
  } catch (const std::bad_alloc&) {
    code = exit_out_of_memory;
  } catch (...) {
    code = exit_without_result;
  }
#ifdef BALANCE_COVERAGE
  __gcov_dump();
#endif
  ::_exit(code);
}

[[noreturn]] void run_child(const std::function<void(int)>& work, const SandboxLimits& limits, SandboxAccess access,
                            pid_t parent, int socket) {
  ::setpgid(0, 0);
  reset_signal_handlers();
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(exit_without_result);  // the parent ended before the child asked for its signal
  const std::uintmax_t memory_bytes = limits.memory_bytes + data_segment_bytes();
  if (access == SandboxAccess::socket_only) {
    drop_access(socket);
    socket = child_socket_descriptor;
  }
  limit_resources(limits, std::max(limits.memory_bytes, memory_bytes));  // the sum may overflow
  run_and_exit(work, socket);
}

}  // namespace

SandboxProcess::SandboxProcess(const std::function<void(int)>& work, const SandboxLimits& limits,
                               SandboxAccess access) {
  int sockets[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, sockets) != 0)
    throw std::system_error(errno, std::generic_category());
  const pid_t parent = ::getpid();
  {
    const Hdf5Lock lock;  // no other thread is inside the library while its state is copied
    child_ = ::fork();
    if (child_ == 0) {
      Hdf5Lock::reset_after_fork();
      ::close(sockets[0]);
      run_child(work, limits, access, parent, sockets[1]);
    }
  }
  const int error = errno;
  ::close(sockets[1]);
  if (child_ < 0) {
    ::close(sockets[0]);
    throw std::system_error(error, std::generic_category());
  }
  ::setpgid(child_, child_);  // by parent or child, whichever runs first
  socket_ = sockets[0];
}

SandboxProcess::~SandboxProcess() {
  ::close(socket_);
  if (exit_status_) return;
  ::kill(-child_, SIGKILL);
  ::kill(child_, SIGKILL);  // in case it has no group yet
  wait(0);
}

std::optional<int> SandboxProcess::find_exit_status() {
  if (!exit_status_) wait(WNOHANG);
  return exit_status_;
}

void SandboxProcess::finish() {
  ::shutdown(socket_, SHUT_RDWR);  // closing is not enough: later children have copies
  if (!exit_status_) wait(0);
}

void SandboxProcess::wait(int options) {
  int status = 0;
  pid_t ended_child = 0;
  do ended_child = ::waitpid(child_, &status, options);
  while (ended_child < 0 && errno == EINTR);
  if (ended_child != 0) exit_status_ = status;
}

void forbid_opening_files() { set_resource_limit(RLIMIT_NOFILE, 0); }

void Message::write(std::uint64_t number) {
  char bytes[sizeof number];
  std::memcpy(bytes, &number, sizeof number);
  bytes_.append(bytes, sizeof number);
}

void Message::write(const std::string& text) {
  write(std::uint64_t{text.size()});
  bytes_ += text;
}

std::uint64_t Message::read_number() {
  std::uint64_t number = 0;
  if (bytes_.size() - position_ < sizeof number) throw ChannelError("a message is too short");
  std::memcpy(&number, bytes_.data() + position_, sizeof number);
  position_ += sizeof number;
  return number;
}

std::string Message::read_text() {
  const std::uint64_t length = read_number();
  if (bytes_.size() - position_ < length) throw ChannelError("a message is too short");
  position_ += length;
  return bytes_.substr(position_ - length, length);
}

void MessageChannel::send(const Message& message) const {
  const std::uint64_t length = message.bytes().size();
  send_bytes(&length, sizeof length);
  send_bytes(message.bytes().data(), message.bytes().size());
}

Message MessageChannel::receive(std::size_t max_bytes) const {
  std::uint64_t length = 0;
  receive_bytes(&length, sizeof length);
  if (length > max_bytes) throw ChannelError("a message is too long");
  std::string bytes(length, '\0');
  receive_bytes(bytes.data(), bytes.size());
  return Message(std::move(bytes));
}

void MessageChannel::send(std::span<const double> values) const { send_bytes(values.data(), values.size_bytes()); }

void MessageChannel::receive(std::span<double> values) const { receive_bytes(values.data(), values.size_bytes()); }

void MessageChannel::send_bytes(const void* from, std::size_t count) const {
  for (std::size_t done = 0; done < count;) {
    const ssize_t transferred = ::send(socket_, static_cast<const char*>(from) + done, count - done, MSG_NOSIGNAL);
    if (transferred < 0 && errno == EINTR) continue;
    if (transferred <= 0) throw ChannelError("nobody listens");
    done += static_cast<std::size_t>(transferred);
  }
}

void MessageChannel::receive_bytes(void* to, std::size_t count) const {
  for (std::size_t done = 0; done < count;) {
    const ssize_t transferred = ::recv(socket_, static_cast<char*>(to) + done, count - done, 0);
    if (transferred < 0 && errno == EINTR) continue;
    if (transferred <= 0) throw ChannelError("nobody speaks");
    done += static_cast<std::size_t>(transferred);
  }
}

}  // namespace balance::hdf5
