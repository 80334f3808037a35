#include "help_text.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <sstream>

namespace balance::app {
namespace {

constexpr int widest = 100, narrowest = 40;

/// Where a line's description begins: behind the first gap of two blanks that follows a word, else where the line itself does.
std::size_t indent_of(const std::string& line) {
  const std::size_t text = std::min(line.find_first_not_of(' '), line.size());
  const std::size_t gap = line.find("  ", text);
  const bool table = text > 0 && gap != std::string::npos;
  return table ? std::min(line.find_first_not_of(' ', gap), line.size()) : text;
}

void append_wrapped(std::string& out, std::string line, std::size_t width) {
  const std::size_t indent = std::min(indent_of(line), width / 2);
  while (line.size() > width) {
    std::size_t blank = line.rfind(' ', width);
    if (blank == std::string::npos || blank <= indent) blank = line.find(' ', width);  // a word longer than the line
    if (blank == std::string::npos) break;
    out += line.substr(0, blank) + "\n";
    line = std::string(indent, ' ') + line.substr(blank + 1);
  }
  out += line + "\n";
}

}  // namespace

int help_width() {
  winsize size{};
  if (::isatty(STDOUT_FILENO) != 1 || ::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return widest;
  return std::clamp(static_cast<int>(size.ws_col), narrowest, widest);
}

std::string wrapped(const std::string& help, int width) {
  std::istringstream lines(help);
  std::string out, line;
  bool examples = false;
  while (std::getline(lines, line)) {
    examples = line == "Examples:" || (examples && !line.empty());
    if (examples)
      out += line + "\n";
    else
      append_wrapped(out, line, static_cast<std::size_t>(width));
  }
  return out;
}

}  // namespace balance::app
