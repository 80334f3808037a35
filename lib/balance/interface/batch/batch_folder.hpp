#pragma once
/// The folder that a batch writes to: used by one batch at a time, or by several shards of one.

#include "balance/interface/batch/batch_plan.hpp"

#include <optional>
#include <set>
#include <string>
#include <vector>

namespace balance::batch {

class BatchFolder {
 public:
  /// Creates the folder if it does not exist, locks it for this process, and removes unfinished files of a killed batch
  /// and symbolic links in the places of its own files. The lock ends with the process and its children, even if they
  /// are killed.
  /// @param shard locks the folder for this shard only; std::nullopt: for this process alone
  /// @param case_names the cases that this process computes: only their unfinished files are certainly its own
  /// @param force use a folder that contains other files
  /// @throws SystemError if it cannot be created or written, contains other files or is locked by another process
  BatchFolder(const std::string& path, const std::optional<Shard>& shard, const std::vector<std::string>& case_names,
              bool force);
  ~BatchFolder();
  BatchFolder(const BatchFolder&) = delete;
  BatchFolder& operator=(const BatchFolder&) = delete;

  const std::string& path() const { return path_; }

  /// Removes the unfinished files of a case whose process ended prematurely.
  void remove_unfinished(const std::string& case_name) const;

  /// Waits until everything written is on disk.
  void sync() const;

 private:
  void lock(const std::string& name, int operation, const std::string& holder);
  void remove_stale_files(const std::optional<Shard>& shard, const std::vector<std::string>& case_names) const;
  void remove_abandoned(const std::set<std::string>& targets) const;

  std::string path_;
  std::vector<int> locks_;  ///< descriptors of the lock files
};

/// Checks whether the batch would overwrite one of its inputs: a file of the suite with the identity of one that the
/// batch writes to the folder, whatever their names. Returns a sentence about the first one found; empty if there is
/// none.
std::string find_overwritten_input(const BatchPlan& plan, const std::string& folder);

}  // namespace balance::batch
