#include "balance/interface/files/atomic_file.hpp"

#include "balance/foundation/base/file_error.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <random>

namespace balance::files {

std::string resolve_path(const std::string& path) {
  std::error_code error;
  // The canonical form of a relative path is absolute only if some of it exists.
  const std::filesystem::path absolute_path = std::filesystem::absolute(path, error);
  if (path.empty() || error) return path;
  std::filesystem::path folder = absolute_path.parent_path();
  // Once `missing/..` has been removed, the rest may contain links.
  for (std::filesystem::path previous; folder != previous;) {
    previous = folder;
    folder = std::filesystem::weakly_canonical(folder, error);
    if (error) return path;
  }
  const std::filesystem::path name = absolute_path.filename();
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
  const auto identity_a = find_file_identity(a), identity_b = find_file_identity(b);
  if (identity_a && identity_b) return identity_a == identity_b;
  if (identity_a || identity_b) return false;
  return resolve_path(a) == resolve_path(b);
}

const InputFile* find_replaced_input(const std::string& output, const std::vector<InputFile>& inputs) {
  if (output.empty() || output == standard_output_path) return nullptr;
  const auto replaced = std::find_if(inputs.begin(), inputs.end(), [&](const InputFile& input) {
    if (input.path.empty()) return false;
    if (const auto identity = identity_of_input(input.path)) return identity == find_file_identity(output);
    return is_same_file(output, input.path);
  });
  return replaced == inputs.end() ? nullptr : &*replaced;
}

namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::string& path, const std::string& reason) {
  throw SystemError(fmt::format("cannot write {}: {}", path, reason));
}

[[noreturn]] void fail(const std::string& path, int error, const std::string& reason) {
  throw FileError(fmt::format("cannot write {}: {}", path, reason), error);
}

[[noreturn]] void fail(const std::string& path, int error) { fail(path, error, std::strerror(error)); }

[[noreturn]] void fail_existing(const std::string& path) {
  fail(path, EEXIST, "it exists already; --force replaces it");
}

std::string folder_of(const std::string& path) {
  const fs::path folder = fs::path(path).parent_path();
  return folder.empty() ? "." : folder.string();
}

/// The nearest existing folder above a file to be created. @throws SystemError if a file is in the place of a folder
std::string find_existing_parent_folder(const std::string& path) {
  for (fs::path folder = folder_of(resolve_path(path));; folder = folder.parent_path()) {
    struct stat status {};
    if (::stat(folder.c_str(), &status) == 0) {
      if (!S_ISDIR(status.st_mode)) fail(path, ENOTDIR, folder.string() + " is a file, not a folder");
      return folder.string();
    }
    if (errno == ENOTDIR && folder.has_relative_path()) continue;  // the file is further up
    if (errno != ENOENT || !folder.has_relative_path()) fail(path, errno);
  }
}

void check_target(const std::string& path, OverwritePolicy existing) {
  if (path.empty()) throw SystemError("cannot write a file without a name");
  struct stat status {};
  if (::lstat(resolve_path(path).c_str(), &status) != 0) {
    if (errno != ENOENT && errno != ENOTDIR) fail(path, errno);
    find_existing_parent_folder(path);
    if (fs::path(path).filename().empty()) fail(path, EISDIR, "it is a folder's name, not a file's");
    return;
  }
  if (S_ISLNK(status.st_mode)) fail(path, "it is a symbolic link, which is not followed; name the file itself");
  if (S_ISDIR(status.st_mode)) fail(path, EISDIR, "it is a folder");
  if (!S_ISREG(status.st_mode)) fail(path, "it is not a regular file");
  if (existing == OverwritePolicy::forbid) fail_existing(path);
}

/// @param target a resolved path, so that no folder is created that `..` leaves again
void create_parent_folder(const std::string& target, const std::string& path) {
  std::error_code error;
  fs::create_directories(folder_of(target), error);
  if (error) fail(path, error.value(), "cannot make its folder: " + error.message());
}

/// A hidden file in the target's folder whose name nobody else uses.
std::string temporary_name(const std::string& target, std::string_view mark) {
  // File systems limit names to 255 bytes, and the target may use them all.
  const std::string name = fs::path(target).filename().string().substr(0, 200);
  return (fs::path(folder_of(target)) / fmt::format(".{}.{}{:08x}.tmp", name, mark, std::random_device{}())).string();
}

/// Renames without replacing an existing file; not atomically if the file system does not support it. @return false on
/// failure, with errno set
bool rename_exclusively(const std::string& from, const std::string& to) {
#ifdef RENAME_NOREPLACE
  if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return true;
  if (errno != EINVAL && errno != ENOSYS) return false;
#endif
  if (::access(to.c_str(), F_OK) == 0) {
    errno = EEXIST;
    return false;
  }
  return ::rename(from.c_str(), to.c_str()) == 0;
}

/// Makes the new name survive a power failure. Failing to sync the folder is no error: the file is complete.
void sync_folder(const std::string& target) {
  const int folder = ::open(folder_of(target).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0) return;
  ::fsync(folder);
  ::close(folder);
}

/// An unnamed file in the folder for temporary files. @return its descriptor, or -1
int open_unnamed() {
  std::error_code error;
  const fs::path folder = fs::temp_directory_path(error);
  std::string name = ((error ? fs::path("/tmp") : folder) / "balance.XXXXXX").string();
  const int descriptor = ::mkostemp(name.data(), O_CLOEXEC);
  if (descriptor >= 0) ::unlink(name.c_str());
  return descriptor;
}

void write_all(int descriptor, std::string_view bytes, const std::string& shown_name) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(shown_name, errno);
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

}  // namespace

std::string parse_temporary_name(const std::string& name, std::string_view mark) {
  constexpr std::size_t random_digits = 8;
  constexpr std::string_view ending = ".tmp";
  if (name.empty() || name[0] != '.' || !name.ends_with(ending)) return "";
  const std::string_view stem = std::string_view(name).substr(1, name.size() - 1 - ending.size());
  const std::size_t suffix_length = 1 + mark.size() + random_digits;
  if (stem.size() <= suffix_length) return "";
  const std::string_view suffix = stem.substr(stem.size() - suffix_length);
  const std::string_view digits = suffix.substr(suffix_length - random_digits);
  const bool numbered =
      std::all_of(digits.begin(), digits.end(), [](unsigned char c) { return std::isxdigit(c) != 0; });
  const bool marked = suffix[0] == '.' && suffix.substr(1, mark.size()) == mark;
  return numbered && marked ? std::string(stem.substr(0, stem.size() - suffix_length)) : "";
}

void remove_stale_temporary(const std::string& temporary) {
  const int descriptor = ::open(temporary.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) return;
  if (::flock(descriptor, LOCK_EX | LOCK_NB) == 0) ::unlink(temporary.c_str());
  ::close(descriptor);
}

void check_writable(const std::string& path, OverwritePolicy existing) {
  if (path == standard_output_path) return;
  check_target(path, existing);
  if (::access(find_existing_parent_folder(path).c_str(), W_OK | X_OK) != 0) fail(path, errno);
}

AtomicFile::AtomicFile(const std::string& path, OverwritePolicy existing, std::string_view mark)
    : path_(path), target_(resolve_path(path)), existing_(existing) {
  if (path == standard_output_path) {
    descriptor_ = open_unnamed();
    if (descriptor_ < 0) fail("a temporary file", errno);
    return;
  }
  check_target(path_, existing_);
  create_parent_folder(target_, path_);
  constexpr int max_name_attempts = 8;  // even two equal random names are unlikely
  for (int attempt = 0; attempt < max_name_attempts; ++attempt) {
    temporary_ = temporary_name(target_, mark);
    descriptor_ = ::open(temporary_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (descriptor_ < 0 && errno == EEXIST) continue;
    if (descriptor_ < 0) break;
    ::flock(descriptor_, LOCK_EX | LOCK_NB);  // if the file system has no locks, nobody else can take one either
    return;
  }
  fail(path_, errno);
}

AtomicFile::~AtomicFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

void AtomicFile::write(std::string_view bytes) { write_all(descriptor_, bytes, path_); }

void AtomicFile::copy_to_standard_output() {
  if (::lseek(descriptor_, 0, SEEK_SET) < 0) fail(path_, errno);
  std::string block(1 << 20, '\0');
  while (true) {
    const ssize_t count = ::read(descriptor_, block.data(), block.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail(path_, errno);
    if (count == 0) return;
    write_all(STDOUT_FILENO, {block.data(), static_cast<std::size_t>(count)}, "standard output");
  }
}

void AtomicFile::commit(Durability durability) {
  if (path_ == standard_output_path) return copy_to_standard_output();
  if (durability == Durability::synced && ::fsync(descriptor_) != 0) fail(path_, errno);
  struct stat old_status {};
  if (existing_ == OverwritePolicy::replace && ::lstat(target_.c_str(), &old_status) == 0)
    ::fchmod(descriptor_, old_status.st_mode & 0777);  // if the file system has no permissions, there are none to keep
  const int descriptor = descriptor_;
  descriptor_ = -1;
  if (::close(descriptor) != 0) fail(path_, errno);
  const bool renamed = existing_ == OverwritePolicy::forbid ? rename_exclusively(temporary_, target_)
                                                            : ::rename(temporary_.c_str(), target_.c_str()) == 0;
  if (!renamed && errno == EEXIST) fail_existing(path_);
  if (!renamed) fail(path_, errno);
  temporary_.clear();
  if (durability == Durability::synced) sync_folder(target_);
}

}  // namespace balance::files
