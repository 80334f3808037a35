#include "balance/read/read_spec.hpp"

#include "balance/base/error.hpp"
#include "balance/read/reading.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <stdexcept>

namespace balance {

namespace {

std::string read_text(const std::string& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored))
    throw SystemError(path + ": expected a spec file, found a directory");
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file)
    throw SystemError(path + ": cannot read the spec: " + (errno != 0 ? std::strerror(errno) : "it does not open"));
  // One byte more than a spec may have: a device without an end is refused like a file that is too large.
  std::string text((std::size_t{4} << 20) + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.bad()) throw SystemError(path + ": cannot read the spec: " + std::strerror(errno));
  text.resize(static_cast<std::size_t>(file.gcount()));
  return text;
}

}  // namespace

Study read_spec(const std::string& text, const std::string& file_name, const ReadOptions& options) {
  return read::read_first(text, file_name, options.set).start;
}

Study read_spec_file(const std::string& path, const ReadOptions& options) {
  return read_spec(read_text(path), path, options);
}

DesignSpace read_design_space(const std::string& text, const std::string& file_name, const ReadOptions& options) {
  const auto reading = std::make_shared<const read::Reading>(read::read_first(text, file_name, options.set));
  const auto at = [reading](const VectorX& x) {
    if (x.size() != static_cast<Eigen::Index>(reading->start.free_numbers.size()))
      throw std::invalid_argument(
          fmt::format("expected {} values of free numbers, found {}", reading->start.free_numbers.size(), x.size()));
    return read::read_again(*reading, x);
  };
  return {reading->start, at};
}

DesignSpace read_design_space_file(const std::string& path, const ReadOptions& options) {
  return read_design_space(read_text(path), path, options);
}

}  // namespace balance
