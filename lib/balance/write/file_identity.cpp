#include "balance/write/file_identity.hpp"

#include "balance/write/pending_file.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <filesystem>

namespace balance {

std::string resolved_path(const std::string& path) {
  const std::filesystem::path whole(path);
  std::error_code error;
  std::filesystem::path folder = whole.has_parent_path() ? whole.parent_path() : ".";
  // Once `missing/..` is gone, what stands behind it may have links of its own.
  for (std::filesystem::path before; folder != before;) {
    before = folder;
    folder = std::filesystem::weakly_canonical(folder, error);
    if (error) return path;
  }
  const std::filesystem::path name = whole.filename();
  return name.empty() ? folder.string() + "/" : (folder / name).string();
}

std::optional<FileIdentity> identity_of(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0 && ::stat(resolved_path(path).c_str(), &status) != 0) return std::nullopt;
  return FileIdentity(status.st_dev, status.st_ino);
}

bool same_file(const std::string& a, const std::string& b) {
  if (a == standard_output || b == standard_output) return false;
  const auto one = identity_of(a), other = identity_of(b);
  if (one && other) return one == other;
  if (one || other) return false;
  return resolved_path(a) == resolved_path(b);
}

const InputFile* find_replaced(const std::string& output, const std::vector<InputFile>& inputs) {
  if (output.empty() || output == standard_output) return nullptr;
  const auto found = std::find_if(inputs.begin(), inputs.end(), [&](const InputFile& input) {
    return !input.path.empty() && same_file(output, input.path);
  });
  return found == inputs.end() ? nullptr : &*found;
}

}  // namespace balance
