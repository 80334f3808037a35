#include "balance/hdf5/expendable.hpp"

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
#include <initializer_list>
#include <system_error>

namespace balance {

namespace {

constexpr int line_in_child = 3;

void limit(int resource, std::uintmax_t most) {
  struct rlimit now {};
  if (::getrlimit(static_cast<__rlimit_resource>(resource), &now) != 0) return;
  const auto wanted = static_cast<rlim_t>(most);
  now.rlim_max = now.rlim_max == RLIM_INFINITY ? wanted : std::min(wanted, now.rlim_max);
  now.rlim_cur = now.rlim_max;
  ::setrlimit(static_cast<__rlimit_resource>(resource), &now);
}

/// Bytes of data that this process has now.
std::uintmax_t data_in_use() {
  std::uintmax_t pages = 0;
  if (std::FILE* file = std::fopen("/proc/self/statm", "re")) {
    if (std::fscanf(file, "%*u %*u %*u %*u %*u %ju", &pages) != 1) pages = 0;
    std::fclose(file);
  }
  return pages * static_cast<std::uintmax_t>(::sysconf(_SC_PAGESIZE));
}

/// Nothing of the parent's but the line, which becomes the first descriptor after the standard ones.
void keep_only(int line) {
  const int nowhere = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  for (const int standard : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::dup2(nowhere, standard);
  if (line != line_in_child) ::dup2(line, line_in_child);
  ::close_range(line_in_child + 1, ~0U, 0);
}

/// Whoever handles signals in the parent is not meant here, and nobody is to be bothered.
void become_expendable(const ExpendableLimits& limits) {
  for (const int signal : {SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT, SIGXCPU, SIGINT, SIGTERM, SIGHUP, SIGPIPE})
    std::signal(signal, SIG_DFL);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_FSIZE, 0);
  limit(RLIMIT_CPU, limits.seconds);
#ifndef BALANCE_SANITIZED  // sanitizers keep a shadow of the memory, which counts
  limit(RLIMIT_DATA, limits.bytes);
#endif
}

[[noreturn]] void run_child(const std::function<void(int)>& work, const ExpendableLimits& limits, int line) {
  keep_only(line);
  become_expendable(limits);
  int code = 0;
  try {
    work(line_in_child);
  } catch (...) {
    code = 1;
  }
  ::_exit(code);
}

}  // namespace

Expendable::Expendable(const std::function<void(int)>& work, const ExpendableLimits& limits) {
  const ExpendableLimits all{limits.seconds, limits.bytes + data_in_use()};
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

Expendable::~Expendable() {
  ::close(line_);
  ::kill(child_, SIGKILL);
  while (::waitpid(child_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

void open_no_more_files() { limit(RLIMIT_NOFILE, 0); }

}  // namespace balance
