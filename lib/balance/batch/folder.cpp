#include "balance/batch/folder.hpp"

#include "balance/base/error.hpp"
#include "balance/batch/case_record.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <set>

namespace balance {
namespace {

namespace fs = std::filesystem;

constexpr const char* lock_name = ".batch.lock";

/// The file that a temporary one (`.name.xxxxxxxx.tmp`) was to become; empty if it is none of ours.
std::string target_of(const std::string& name) {
  constexpr std::size_t ending = 13;  // .xxxxxxxx.tmp
  if (name.size() <= ending + 1 || name[0] != '.' || !name.ends_with(".tmp")) return "";
  const std::string digits = name.substr(name.size() - ending, 9);
  const bool ours = digits[0] == '.' && std::all_of(digits.begin() + 1, digits.end(),
                                                    [](unsigned char c) { return std::isxdigit(c) != 0; });
  return ours ? name.substr(1, name.size() - ending - 1) : "";
}

void make_folder(const std::string& path, bool force) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error) throw SystemError(fmt::format("cannot make the folder {}: {}", path, error.message()));
  if (force || fs::exists(fs::path(path) / lock_name, error) || fs::is_empty(path, error)) return;
  // Another shard may have been quicker by a moment.
  if (fs::exists(fs::path(path) / lock_name, error)) return;
  throw SystemError(fmt::format("{} is neither empty nor the folder of a batch; --force uses it all the same", path));
}

}  // namespace

BatchFolder::BatchFolder(const std::string& path, const std::optional<Shard>& shard,
                         const std::vector<std::string>& own, bool force)
    : path_(path) {
  make_folder(path, force);
  try {
    take(lock_name, shard ? LOCK_SH : LOCK_EX, "another batch");
    if (shard)
      take(fmt::format(".batch-{}-of-{}.lock", shard->index, shard->count), LOCK_EX,
           fmt::format("another shard {}/{}", shard->index, shard->count));
    clean(shard, own);
  } catch (...) {
    for (const int lock : locks_) ::close(lock);
    throw;
  }
}

BatchFolder::~BatchFolder() {
  for (const int lock : locks_) ::close(lock);
}

void BatchFolder::take(const std::string& name, int operation, const std::string& whose) {
  const std::string file = (fs::path(path_) / name).string();
  const int descriptor = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (descriptor < 0) throw SystemError(fmt::format("cannot write {}: {}", file, std::strerror(errno)));
  locks_.push_back(descriptor);
  int result = 0;
  do result = ::flock(descriptor, operation | LOCK_NB);
  while (result != 0 && errno == EINTR);
  if (result == 0) return;
  if (errno == EWOULDBLOCK) throw SystemError(fmt::format("{} is at work in {}", whose, path_));
  throw SystemError(fmt::format("cannot lock {}: {}", file, std::strerror(errno)));
}

void BatchFolder::clean(const std::optional<Shard>& shard, const std::vector<std::string>& own) const {
  std::set<std::string> files;
  for (const std::string& name : own) files.insert({record_file(name), result_file(name), balanced_file(name)});
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(path_, error)) {
    const std::string target = target_of(entry.path().filename().string());
    if (target.empty() || (shard && files.count(target) == 0)) continue;
    std::error_code ignored;
    fs::remove(entry.path(), ignored);
  }
}

void BatchFolder::sync() const {
  if (!locks_.empty()) ::syncfs(locks_.front());
}

}  // namespace balance
