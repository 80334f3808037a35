#include "balance/write/file_identity.hpp"

#include "balance/write/pending_file.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

namespace balance {

std::string resolve_path(const std::string& path) {
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

std::optional<FileIdentity> find_file_identity(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0 && ::stat(resolve_path(path).c_str(), &status) != 0) return std::nullopt;
  return FileIdentity(status.st_dev, status.st_ino);
}

std::optional<FileIdentity> identity_of_input(const std::string& path) {
  if (path != "-" && path != "<stdin>") return find_file_identity(path);
  struct stat status {};
  if (::fstat(STDIN_FILENO, &status) != 0 || !S_ISREG(status.st_mode)) return std::nullopt;
  return FileIdentity(status.st_dev, status.st_ino);
}

bool is_same_file(const std::string& a, const std::string& b) {
  if (a == standard_output_path || b == standard_output_path) return false;
  const auto one = find_file_identity(a), other = find_file_identity(b);
  if (one && other) return one == other;
  if (one || other) return false;
  return resolve_path(a) == resolve_path(b);
}

const InputFile* find_replaced_input(const std::string& output, const std::vector<InputFile>& inputs) {
  if (output.empty() || output == standard_output_path) return nullptr;
  const auto found = std::find_if(inputs.begin(), inputs.end(), [&](const InputFile& input) {
    if (input.path.empty()) return false;
    if (const auto read = identity_of_input(input.path)) return read == find_file_identity(output);
    return is_same_file(output, input.path);
  });
  return found == inputs.end() ? nullptr : &*found;
}

}  // namespace balance
