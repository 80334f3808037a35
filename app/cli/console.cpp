#include "cli/console.hpp"
#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/unicode_text.hpp"
#include "balance/interface/files/atomic_file.hpp"
#include "balance/interface/files/text_table.hpp"

#include <fcntl.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <initializer_list>

namespace balance::app {

void reserve_standard_descriptors() {
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    // open() returns the lowest free descriptor. Read-only, so that writing to a closed stdout remains an error.
    if (::fcntl(descriptor, F_GETFD) < 0 && ::open("/dev/null", O_RDONLY) < 0) return;
  }
}

void print(const std::string& text) {
  const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
  if (!written || std::fflush(stdout) != 0) {
    throw SystemError(std::string("cannot write to standard output: ") + std::strerror(errno));
  }
}

void print_text(const std::string& text) { print(escape_lines_for_terminal(text)); }

void print_status(const std::vector<std::string>& files, const std::string& text) {
  if (std::find(files.begin(), files.end(), files::standard_output_path) == files.end()) return print_text(text);
  std::fputs(escape_lines_for_terminal(text).c_str(), stderr);
}

std::string format_written_message(const std::string& file, const std::string& what) {
  return file == files::standard_output_path ? "" : what + ": " + escape_for_terminal(file) + "\n";
}

void print_message(const std::string& text) { print_message_lines(escape_for_terminal(text)); }

void print_message_lines(const std::string& text) {
  std::fprintf(stderr, "%s\n", escape_lines_for_terminal(text).c_str());
}

std::size_t text_width() {
  winsize size{};
  if (::isatty(STDOUT_FILENO) != 1 || ::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0) return files::default_text_width;
  return std::max<std::size_t>(size.ws_col, files::default_text_width);
}

ProgressLine::ProgressLine(bool quiet) : is_shown_(!quiet && ::isatty(STDERR_FILENO) == 1) {}

ProgressLine::~ProgressLine() {
  if (is_shown_ && is_drawn_) std::fputs("\r\033[K", stderr);
}

void ProgressLine::draw(const std::string& text) {
  if (!is_shown_) return;
  std::fprintf(stderr, "\r\033[K%s", text.c_str());
  is_drawn_ = true;
}

void ProgressLine::draw_fraction(const std::string& what, double fraction) {
  const auto now = std::chrono::steady_clock::now();
  if (!is_shown_ || now - last_ < std::chrono::seconds(1)) return;
  last_ = now;
  draw(what + ": " + std::to_string(static_cast<int>(100 * fraction)) + " %");
}

}  // namespace balance::app
