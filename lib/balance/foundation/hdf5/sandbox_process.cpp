#include "balance/foundation/hdf5/sandbox_process.hpp"

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
#include <system_error>

namespace balance {

namespace {

constexpr int child_socket_descriptor = 3;

void set_resource_limit(int resource, std::uintmax_t most) {
  struct rlimit now {};
  if (::getrlimit(static_cast<__rlimit_resource>(resource), &now) != 0) return;
  const auto wanted = static_cast<rlim_t>(most);
  now.rlim_max = now.rlim_max == RLIM_INFINITY ? wanted : std::min(wanted, now.rlim_max);
  now.rlim_cur = now.rlim_max;
  ::setrlimit(static_cast<__rlimit_resource>(resource), &now);
}

/// Bytes of data that this process has now.
std::uintmax_t data_segment_bytes() {
  std::uintmax_t pages = 0;
  if (std::FILE* file = std::fopen("/proc/self/statm", "re")) {
    if (std::fscanf(file, "%*u %*u %*u %*u %*u %ju", &pages) != 1) pages = 0;
    std::fclose(file);
  }
  return pages * static_cast<std::uintmax_t>(::sysconf(_SC_PAGESIZE));
}

/// Nothing of the parent's but the line, which becomes the first descriptor after the standard ones.
void close_other_descriptors(int line) {
  const int nowhere = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  for (const int standard : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::dup2(nowhere, standard);
  if (line != child_socket_descriptor) ::dup2(line, child_socket_descriptor);
  ::close_range(child_socket_descriptor + 1, ~0U, 0);
}

/// Whoever handles signals in the parent is not meant here, and nobody is to be bothered.
void drop_privileges(const SandboxLimits& limits) {
  for (const int signal : {SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT, SIGXCPU, SIGINT, SIGTERM, SIGHUP, SIGPIPE})
    std::signal(signal, SIG_DFL);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  set_resource_limit(RLIMIT_CORE, 0);
  set_resource_limit(RLIMIT_FSIZE, 0);
  set_resource_limit(RLIMIT_CPU, limits.cpu_seconds);
#ifndef BALANCE_SANITIZED  // sanitizers keep a shadow of the memory, which counts
  set_resource_limit(RLIMIT_DATA, limits.memory_bytes);
#endif
}

[[noreturn]] void run_child(const std::function<void(int)>& work, const SandboxLimits& limits, int line) {
  close_other_descriptors(line);
  drop_privileges(limits);
  int code = 0;
  try {
    work(child_socket_descriptor);
  } catch (...) {
    code = 1;
  }
  ::_exit(code);
}

}  // namespace

SandboxProcess::SandboxProcess(const std::function<void(int)>& work, const SandboxLimits& limits) {
  const SandboxLimits all{limits.cpu_seconds, limits.memory_bytes + data_segment_bytes()};
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
    throw std::system_error(errno, std::generic_category());
  child_ = ::fork();
  if (child_ == 0) run_child(work, all, ends[1]);
  const int error = errno;
  ::close(ends[1]);
  if (child_ < 0) {
    ::close(ends[0]);
    throw std::system_error(error, std::generic_category());
  }
  line_ = ends[0];
}

SandboxProcess::~SandboxProcess() {
  ::close(line_);
  ::kill(child_, SIGKILL);
  while (::waitpid(child_, nullptr, 0) < 0 && errno == EINTR) {
  }
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
  if (bytes_.size() - at_ < sizeof number) throw ChannelError("a message is too short");
  std::memcpy(&number, bytes_.data() + at_, sizeof number);
  at_ += sizeof number;
  return number;
}

std::string Message::read_text() {
  const std::uint64_t length = read_number();
  if (bytes_.size() - at_ < length) throw ChannelError("a message is too short");
  at_ += length;
  return bytes_.substr(at_ - length, length);
}

void MessageChannel::send(const Message& message) const {
  const std::uint64_t length = message.bytes().size();
  send_bytes(&length, sizeof length);
  send_bytes(message.bytes().data(), message.bytes().size());
}

Message MessageChannel::receive(std::size_t most) const {
  std::uint64_t length = 0;
  receive_bytes(&length, sizeof length);
  if (length > most) throw ChannelError("a message is too long");
  std::string bytes(length, '\0');
  receive_bytes(bytes.data(), bytes.size());
  return Message(std::move(bytes));
}

void MessageChannel::send(std::span<const double> values) const { send_bytes(values.data(), values.size_bytes()); }

void MessageChannel::receive(std::span<double> values) const { receive_bytes(values.data(), values.size_bytes()); }

void MessageChannel::send_bytes(const void* from, std::size_t count) const {
  for (std::size_t done = 0; done < count;) {
    const ssize_t now = ::send(socket_, static_cast<const char*>(from) + done, count - done, MSG_NOSIGNAL);
    if (now < 0 && errno == EINTR) continue;
    if (now <= 0) throw ChannelError("nobody listens");
    done += static_cast<std::size_t>(now);
  }
}

void MessageChannel::receive_bytes(void* to, std::size_t count) const {
  for (std::size_t done = 0; done < count;) {
    const ssize_t now = ::recv(socket_, static_cast<char*>(to) + done, count - done, 0);
    if (now < 0 && errno == EINTR) continue;
    if (now <= 0) throw ChannelError("nobody speaks");
    done += static_cast<std::size_t>(now);
  }
}

}  // namespace balance
