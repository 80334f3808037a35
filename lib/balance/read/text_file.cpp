#include "balance/read/text_file.hpp"

#include "balance/base/error.hpp"
#include "balance/read/node.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace balance {

std::string read_text_file(const std::string& path, const std::string& what) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored))
    throw SystemError(fmt::format("{}: expected a {} file, found a directory", path, what));
  const auto fail = [&](const char* reason) {
    throw SystemError(fmt::format("{}: cannot read the {}: {}", path, what, reason));
  };
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) fail(errno != 0 ? std::strerror(errno) : "it does not open");
  // One byte more than a document may have: a device without an end is refused like a file that is too large.
  std::string text(read::DocumentLimits{}.bytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.bad()) fail(std::strerror(errno));
  text.resize(static_cast<std::size_t>(file.gcount()));
  return text;
}

}  // namespace balance
