#include "balance/write/file_identity.hpp"

#include "balance/write/pending_file.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

namespace balance {

std::string resolved_path(const std::string& path) {
  std::error_code error;
  // The canonical form of a relative path begins at the root only if some of it exists.
  const std::filesystem::path whole = std::filesystem::absolute(path, error);
  if (path.empty() || error) return path;
  std::filesystem::path folder = whole.parent_path();
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

std::optional<FileIdentity> identity_of_input(const std::string& path) {
  if (path != "-" && path != "<stdin>") return identity_of(path);
  struct stat status {};
  if (::fstat(STDIN_FILENO, &status) != 0 || !S_ISREG(status.st_mode)) return std::nullopt;
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
    if (input.path.empty()) return false;
    if (const auto read = identity_of_input(input.path)) return read == identity_of(output);
    return same_file(output, input.path);
  });
  return found == inputs.end() ? nullptr : &*found;
}

}  // namespace balance
