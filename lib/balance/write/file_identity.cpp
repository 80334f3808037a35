#include "balance/write/file_identity.hpp"

#include "balance/write/pending_file.hpp"

#include <sys/stat.h>

#include <filesystem>

namespace balance {

std::optional<FileIdentity> identity_of(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return std::nullopt;
  return FileIdentity(status.st_dev, status.st_ino);
}

bool same_file(const std::string& a, const std::string& b) {
  if (a == standard_output || b == standard_output) return false;
  const auto one = identity_of(a), other = identity_of(b);
  if (one && other) return one == other;
  if (one || other) return false;
  std::error_code error;
  return std::filesystem::weakly_canonical(a, error) == std::filesystem::weakly_canonical(b, error);
}

}  // namespace balance
