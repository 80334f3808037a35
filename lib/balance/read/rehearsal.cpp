#include "balance/read/rehearsal.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <initializer_list>
#include <stdexcept>
#include <string_view>

namespace balance::read {

namespace {

constexpr int complained = 3;

void limit(int resource, std::uintmax_t most) {
  struct rlimit now {};
  if (::getrlimit(static_cast<__rlimit_resource>(resource), &now) != 0) return;
  now.rlim_cur = now.rlim_max == RLIM_INFINITY || most < now.rlim_max ? static_cast<rlim_t>(most) : now.rlim_max;
  ::setrlimit(static_cast<__rlimit_resource>(resource), &now);
}

/// Bytes of data that this process has now.
[[maybe_unused]] std::uintmax_t data_in_use() {
  std::uintmax_t pages = 0;
  if (std::FILE* file = std::fopen("/proc/self/statm", "re")) {
    if (std::fscanf(file, "%*u %*u %*u %*u %*u %ju", &pages) != 1) pages = 0;
    std::fclose(file);
  }
  return pages * static_cast<std::uintmax_t>(::sysconf(_SC_PAGESIZE));
}

/// Whoever handles signals in the parent is not meant here, and nobody is to be bothered.
void become_expendable(std::uintmax_t bytes) {
  for (const int signal : {SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT, SIGXCPU, SIGINT, SIGTERM, SIGHUP})
    std::signal(signal, SIG_DFL);
  const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  ::dup2(nowhere, STDOUT_FILENO);
  ::dup2(nowhere, STDERR_FILENO);
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_FSIZE, 0);
  limit(RLIMIT_CPU, 1 + bytes / 10'000'000);
#ifndef BALANCE_SANITIZED  // sanitizers keep a shadow of the memory, which counts
  limit(RLIMIT_DATA, data_in_use() + (std::uintmax_t{512} << 20) + 16 * bytes);
#endif
}

[[noreturn]] void run_child(const std::function<void()>& work, std::uintmax_t bytes, int to_parent) {
  become_expendable(bytes);
  int code = 0;
  try {
    work();
  } catch (const std::runtime_error& error) {
    code = complained;
    const std::string_view message = error.what();
    // Shorter than what a pipe takes at once.
    if (::write(to_parent, message.data(), std::min<std::size_t>(message.size(), 4096)) < 0) code = 1;
  } catch (...) {
    code = 1;
  }
  ::_exit(code);
}

std::string read_all(int descriptor) {
  std::string text;
  char part[512];
  for (;;) {
    const ssize_t count = ::read(descriptor, part, sizeof part);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return text;
    text.append(part, static_cast<std::size_t>(count));
  }
}

}  // namespace

Rehearsal rehearse(const std::function<void()>& work, std::uintmax_t bytes) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return {};
  const pid_t child = ::fork();
  if (child == 0) run_child(work, bytes, ends[1]);
  ::close(ends[1]);
  Rehearsal result;
  if (child > 0) {
    result.message = read_all(ends[0]);
    int status = 0;
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    const int code = WIFEXITED(status) ? WEXITSTATUS(status) : 1;
    result.end = code == 0 ? Rehearsed::well : code == complained ? Rehearsed::complained : Rehearsed::died;
  }
  ::close(ends[0]);
  return result;
}

}  // namespace balance::read
