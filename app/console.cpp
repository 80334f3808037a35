#include "console.hpp"

#include "balance/base/error.hpp"
#include "balance/base/plain_text.hpp"
#include "balance/write/pending_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <initializer_list>

namespace balance::app {

void reserve_standard_descriptors() {
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    // open takes the lowest free number. Read-only, so that writing to a closed stdout stays an error.
    if (::fcntl(descriptor, F_GETFD) < 0 && ::open("/dev/null", O_RDONLY) < 0) return;
  }
}

void print(const std::string& text) {
  const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
  if (!written || std::fflush(stdout) != 0) {
    throw SystemError(std::string("cannot write to standard output: ") + std::strerror(errno));
  }
}

void print_text(const std::string& text) { print(visible_lines(text)); }

void print_beside(const std::vector<std::string>& files, const std::string& text) {
  if (std::find(files.begin(), files.end(), standard_output) == files.end()) return print_text(text);
  std::fputs(visible_lines(text).c_str(), stderr);
}

std::string written_line(const std::string& file, const std::string& what) {
  return file == standard_output ? "" : what + ": " + visible(file) + "\n";
}

void tell(const std::string& text) { tell_lines(visible(text)); }

void tell_lines(const std::string& text) { std::fprintf(stderr, "%s\n", visible_lines(text).c_str()); }

}  // namespace balance::app
