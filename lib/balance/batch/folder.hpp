#pragma once
/// The folder that a batch writes into: one batch at a time, or several shards of one.

#include "balance/batch/plan.hpp"

#include <optional>
#include <string>
#include <vector>

namespace balance {

class BatchFolder {
 public:
  /// Makes the folder if it does not exist, takes it for this process and removes what a killed one left unfinished. The process's
  /// end, however it comes, gives the folder free.
  /// @param shard takes the folder for this shard only; nothing: for this process alone
  /// @param own the cases that this process computes: only their unfinished files are surely nobody's
  /// @param force use a folder that holds other things
  /// @throws SystemError if it cannot be made or written, holds other things, or another process has it
  BatchFolder(const std::string& path, const std::optional<Shard>& shard, const std::vector<std::string>& own,
              bool force);
  ~BatchFolder();
  BatchFolder(const BatchFolder&) = delete;
  BatchFolder& operator=(const BatchFolder&) = delete;

  const std::string& path() const { return path_; }

  /// Waits until everything that was written is on disk.
  void sync() const;

 private:
  void take(const std::string& name, int operation, const std::string& whose);
  void clean(const std::optional<Shard>& shard, const std::vector<std::string>& own) const;

  std::string path_;
  std::vector<int> locks_;  ///< descriptors
};

}  // namespace balance
