#include "balance/batch/limits.hpp"

#include <unistd.h>

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

namespace balance {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t mebibyte = std::uintmax_t{1} << 20;

/// A file that holds one number; where it says "max" or cannot be read, there is no limit.
std::uintmax_t limit_in(const fs::path& file, std::uintmax_t otherwise) {
  std::ifstream stream(file);
  std::uintmax_t bytes = 0;
  return stream >> bytes && bytes > 0 ? std::min(bytes, otherwise) : otherwise;
}

/// The least of this process's control group and all above it.
std::uintmax_t cgroup_memory_limit(std::uintmax_t otherwise) {
  const fs::path root = "/sys/fs/cgroup";
  std::uintmax_t least = limit_in(root / "memory/memory.limit_in_bytes", otherwise);
  std::ifstream stream("/proc/self/cgroup");
  for (std::string line; std::getline(stream, line);) {
    if (!line.starts_with("0::/")) continue;
    fs::path group = root / fs::path(line.substr(4));
    for (; group != root && group.has_relative_path(); group = group.parent_path())
      least = limit_in(group / "memory.max", least);
  }
  return limit_in(root / "memory.max", least);
}

}  // namespace

std::uintmax_t available_memory() {
  const long pages = ::sysconf(_SC_PHYS_PAGES), size = ::sysconf(_SC_PAGESIZE);
  if (pages <= 0 || size <= 0) return 0;
  return cgroup_memory_limit(static_cast<std::uintmax_t>(pages) * static_cast<std::uintmax_t>(size));
}

std::uintmax_t memory_per_case(const CaseLimits& limits, unsigned jobs) {
  if (limits.memory_bytes) return *limits.memory_bytes;
  const std::uintmax_t all = available_memory();
  return all == 0 ? 0 : std::max(all / std::max(jobs, 1U), 256 * mebibyte);
}

std::string format_seconds(double seconds) { return fmt::format("{} s", seconds); }

std::string format_bytes(std::uintmax_t bytes) {
  return bytes % mebibyte == 0 ? fmt::format("{} MiB", bytes / mebibyte)
                               : fmt::format("{:.1f} MiB", static_cast<double>(bytes) / static_cast<double>(mebibyte));
}

}  // namespace balance
