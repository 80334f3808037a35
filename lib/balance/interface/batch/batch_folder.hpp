#pragma once
/// The folder that a batch writes into: one batch at a time, or several shards of one.

#include "balance/interface/batch/batch_plan.hpp"

#include <optional>
#include <set>
#include <string>
#include <vector>

namespace balance {

class BatchFolder {
 public:
  /// Makes the folder if it does not exist, takes it for this process, removes what a killed batch left unfinished, and symbolic links
  /// in the places of its own files. The end of the process and its children, however it comes, gives the folder free.
  /// @param shard takes the folder for this shard only; nothing: for this process alone
  /// @param own the cases that this process computes: only their unfinished files are surely its own
  /// @param force use a folder that holds other things
  /// @throws SystemError if it cannot be made or written, holds other things, or another process has it
  BatchFolder(const std::string& path, const std::optional<Shard>& shard, const std::vector<std::string>& own,
              bool force);
  ~BatchFolder();
  BatchFolder(const BatchFolder&) = delete;
  BatchFolder& operator=(const BatchFolder&) = delete;

  const std::string& path() const { return path_; }

  /// Removes the unfinished files of a case whose process did not come to its end.
  void remove_unfinished(const std::string& case_name) const;

  /// Waits until everything that was written is on disk.
  void sync() const;

 private:
  void lock(const std::string& name, int operation, const std::string& whose);
  void remove_stale_files(const std::optional<Shard>& shard, const std::vector<std::string>& own) const;
  void remove_abandoned(const std::set<std::string>& targets) const;

  std::string path_;
  std::vector<int> locks_;  ///< descriptors
};

/// What a batch would replace although it reads it: a file of the suite's that has the identity of one that the batch writes into the
/// folder, whatever the names are. A sentence about the first that is found; empty if there is none.
std::string find_overwritten_input(const BatchPlan& plan, const std::string& folder);

}  // namespace balance
