#include "balance/spec/text_file.hpp"

#include "balance/base/error.hpp"
#include "balance/spec/node.hpp"

#include <unistd.h>

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace balance {
namespace {

/// One byte more than a document may have: a source without an end is refused like a file that is too large.
constexpr std::size_t longest_text = read::DocumentLimits{}.bytes + 1;

std::string read_standard_input(const std::string& what) {
  std::string text(longest_text, '\0');
  std::size_t read = 0;
  while (read < text.size()) {
    const ssize_t count = ::read(STDIN_FILENO, text.data() + read, text.size() - read);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0)
      throw SystemError(fmt::format("{}: cannot read the {}: {}", standard_input, what, std::strerror(errno)));
    if (count == 0) break;
    read += static_cast<std::size_t>(count);
  }
  text.resize(read);
  return text;
}

}  // namespace

std::string read_text_file(const std::string& path, const std::string& what) {
  if (path == "-" || path == standard_input) return read_standard_input(what);
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored))
    throw SystemError(fmt::format("{}: expected a {} file, found a directory", path, what));
  const auto fail = [&](const char* reason) {
    throw SystemError(fmt::format("{}: cannot read the {}: {}", path, what, reason));
  };
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) fail(errno != 0 ? std::strerror(errno) : "it does not open");
  std::string text(longest_text, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.bad()) fail(std::strerror(errno));
  text.resize(static_cast<std::size_t>(file.gcount()));
  return text;
}

}  // namespace balance
