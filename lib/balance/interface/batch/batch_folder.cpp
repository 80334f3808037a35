#include "balance/interface/batch/batch_folder.hpp"

#include "balance/foundation/base/file_error.hpp"
#include "balance/interface/batch/batch_summary.hpp"
#include "balance/interface/batch/case_record.hpp"
#include "balance/interface/files/atomic_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <fmt/format.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <map>
#include <thread>

namespace balance::batch {
namespace {

namespace fs = std::filesystem;

constexpr const char* lock_file_name = ".batch.lock";

/// Names of a case's files in the folder.
std::vector<std::string> files_of(const std::string& case_name) {
  return {record_file_name(case_name), result_file_name(case_name), balanced_spec_file_name(case_name)};
}

void remove_link(const fs::path& path) {
  std::error_code error;
  if (fs::is_symlink(path, error)) fs::remove(path, error);
}

void make_folder(const std::string& path, bool force) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error) throw FileError(fmt::format("cannot make the folder {}: {}", path, error.message()), error.value());
  if (force || fs::exists(fs::path(path) / lock_file_name, error) || fs::is_empty(path, error)) return;
  // Another shard may have created it a moment ago.
  if (fs::exists(fs::path(path) / lock_file_name, error)) return;
  throw FileError(fmt::format("{} is neither empty nor the folder of a batch; --force uses it anyway", path),
                  ENOTEMPTY);
}

}  // namespace

BatchFolder::BatchFolder(const std::string& path, const std::optional<Shard>& shard,
                         const std::vector<std::string>& case_names, bool force)
    : path_(path) {
  make_folder(path, force);
  try {
    lock(lock_file_name, shard ? LOCK_SH : LOCK_EX, "another batch");
    if (shard)
      lock(fmt::format(".batch-{}-of-{}.lock", shard->index, shard->count), LOCK_EX,
           fmt::format("another shard {}/{}", shard->index, shard->count));
    remove_stale_files(shard, case_names);
  } catch (...) {
    for (const int descriptor : locks_) ::close(descriptor);
    throw;
  }
}

BatchFolder::~BatchFolder() {
  for (const int descriptor : locks_) ::close(descriptor);
}

void BatchFolder::lock(const std::string& name, int operation, const std::string& holder) {
  const std::string file = (fs::path(path_) / name).string();
  const int descriptor = ::open(file.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0666);
  if (descriptor < 0 && errno == ELOOP) throw SystemError(fmt::format("cannot write {}: it is a symbolic link", file));
  if (descriptor < 0) throw FileError(fmt::format("cannot write {}: {}", file, std::strerror(errno)), errno);
  locks_.push_back(descriptor);
  // The children of a killed batch end a moment later and hold the lock until then.
  constexpr int max_lock_attempts = 100;
  for (int attempt = 0; ::flock(descriptor, operation | LOCK_NB) != 0; ++attempt) {
    if (errno == EINTR) continue;
    if (errno != EWOULDBLOCK) throw SystemError(fmt::format("cannot lock {}: {}", file, std::strerror(errno)));
    if (attempt >= max_lock_attempts) throw SystemError(fmt::format("{} is running in {}", holder, path_));
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

void BatchFolder::remove_stale_files(const std::optional<Shard>& shard,
                                     const std::vector<std::string>& case_names) const {
  std::set<std::string> targets;
  for (const std::string& name : case_names)
    for (const std::string& file : files_of(name)) targets.insert(file);
  if (!shard)
    for (const char* file : summary_file_names) targets.insert(file);
  for (const std::string& file : targets) remove_link(fs::path(path_) / file);
  remove_abandoned(targets);
}

void BatchFolder::remove_unfinished(const std::string& case_name) const {
  const std::vector<std::string> files = files_of(case_name);
  remove_abandoned({files.begin(), files.end()});
}

void BatchFolder::remove_abandoned(const std::set<std::string>& targets) const {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(path_, error)) {
    const std::string target = files::parse_temporary_name(entry.path().filename().string(), temporary_tag);
    if (targets.count(target) > 0) files::remove_stale_temporary(entry.path().string());
  }
}

void BatchFolder::sync() const {
  if (!locks_.empty()) ::syncfs(locks_.front());
}

std::string find_overwritten_input(const BatchPlan& plan, const std::string& folder) {
  std::map<files::FileIdentity, std::string> inputs;  // a batch has too many files for pairwise comparisons
  const auto add_input = [&](const std::string& file, const std::string& description) {
    if (const auto identity = files::identity_of_input(file)) inputs.emplace(*identity, description + " " + file);
  };
  add_input(plan.suite.file, "the suite");
  for (const SpecSource& spec : plan.specs) {
    add_input(spec.path, "the spec");
    for (const std::string& table : spec.referenced_files) add_input(table, "the table");
  }
  const auto find_conflict = [&](const std::string& name) -> std::string {
    const auto identity = files::find_file_identity((fs::path(folder) / name).string());
    const auto input = identity ? inputs.find(*identity) : inputs.end();
    if (input == inputs.end()) return "";
    return fmt::format("{} would be replaced by {}; name another folder", input->second,
                       (fs::path(folder) / name).string());
  };
  std::vector<std::string> outputs(summary_file_names.begin(), summary_file_names.end());
  outputs.emplace_back(lock_file_name);
  for (const SuiteCase& suite_case : plan.suite.cases)
    for (const std::string& file : files_of(suite_case.name))
      if (suite_case.design || file != balanced_spec_file_name(suite_case.name)) outputs.push_back(file);
  for (const std::string& output : outputs)
    if (std::string conflict = find_conflict(output); !conflict.empty()) return conflict;
  return "";
}

}  // namespace balance::batch
