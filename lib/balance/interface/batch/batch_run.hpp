#pragma once
/// Runs the cases of a plan in child processes, or reuses the results of earlier runs.

#include "balance/interface/batch/batch_plan.hpp"
#include "balance/interface/batch/case_record.hpp"
#include "balance/interface/batch/case_run.hpp"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace balance::batch {

/// Resources that a case of a batch may use.
struct CaseLimits {
  double wall_seconds = 3600;  ///< wall-clock time; 0: no limit
  std::optional<std::uintmax_t>
      memory_bytes;  ///< std::nullopt: an equal share of the machine's memory for every job; 0: no limit
};

/// Memory available to this process and its children [bytes]: the machine's, or the limit of its control groups; 0 if
/// unknown.
std::uintmax_t available_memory();

/// Memory available to a case [bytes]. @param jobs number of concurrent cases, at least one
std::uintmax_t memory_per_case(const CaseLimits& limits, unsigned jobs);

/// "10 s", "512 MiB": in the form that the command line takes.
std::string format_seconds(double seconds);
std::string format_bytes(std::uintmax_t bytes);

struct BatchProgress {
  std::size_t total = 0;          ///< number of cases
  std::size_t finished = 0;       ///< computed now or reused
  std::size_t reused = 0;         ///< finished by an earlier run
  std::size_t reused_failed = 0;  ///< reused cases without a result
  std::size_t failed = 0;         ///< all cases without a result
};

struct BatchOptions {
  std::string folder;                                  ///< output folder; created if it does not exist
  unsigned jobs = 1;                                   ///< number of concurrent cases, at least one
  std::optional<Shard> shard;                          ///< std::nullopt: all cases
  bool force = false;                                  ///< use a folder that contains other files
  std::function<void(const BatchProgress&)> progress;  ///< called after every case, from one thread at a time
  std::function<bool()> cancelled;                     ///< polled ten times a second if set; true ends the batch
  CaseLimits limits;
  StoredOutput stored_output = StoredOutput::series;
  bool retry_failed = false;  ///< compute unchanged cases without a result again
};

struct BatchOutcome {
  std::vector<CaseRecord> records;  ///< of the shard's cases, in the suite's order
  BatchProgress progress;
};

/// Computes the unfinished cases in child processes that end with this one. A case that crashes or exceeds a limit is
/// recorded as failed, and the others continue. The records and files depend neither on options.jobs nor on
/// interruptions of the batch. Children are copies of the calling thread; see SandboxedWorker.
/// @throws SystemError if the folder cannot be used; failures of cases are in their records
/// @throws Cancelled if options.cancelled returns true: finished cases are kept
/// @throws std::invalid_argument if it would overwrite one of its inputs: see find_overwritten_input
BatchOutcome run_batch(const BatchPlan& plan, const BatchOptions& options);

/// Collects what shards have computed. A case that no shard has computed is "missing". @throws SystemError as above
BatchOutcome collect_batch(const BatchPlan& plan, const std::string& folder);

}  // namespace balance::batch
