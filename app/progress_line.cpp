#include "progress_line.hpp"

#include <unistd.h>

#include <cstdio>

namespace balance::app {

ProgressLine::ProgressLine(bool quiet) : shown_(!quiet && ::isatty(STDERR_FILENO) == 1) {}

ProgressLine::~ProgressLine() {
  if (shown_ && drawn_) std::fputs("\r\033[K", stderr);
}

void ProgressLine::draw(const std::string& text) {
  if (!shown_) return;
  std::fprintf(stderr, "\r\033[K%s", text.c_str());
  drawn_ = true;
}

void ProgressLine::draw_fraction(const std::string& what, double part) {
  const auto now = std::chrono::steady_clock::now();
  if (!shown_ || now - last_ < std::chrono::seconds(1)) return;
  last_ = now;
  draw(what + ": " + std::to_string(static_cast<int>(100 * part)) + " %");
}

}  // namespace balance::app
