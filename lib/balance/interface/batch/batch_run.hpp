#pragma once
/// Runs the cases of a plan, each in a process of its own, or finds what other runs left.

#include "balance/interface/batch/batch_plan.hpp"
#include "balance/interface/batch/case_record.hpp"
#include "balance/interface/batch/case_run.hpp"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace balance {

/// What a case of a batch may use of the machine.
struct CaseLimits {
  double wall_seconds = 3600;  ///< by the clock on the wall; 0: no limit
  std::optional<std::uintmax_t>
      memory_bytes;  ///< of memory; nothing: an equal share of the machine's for every job; 0: no limit
};

/// Bytes of memory that this process and its children may have: the machine's, or what its control groups allow; 0 if unknown.
std::uintmax_t available_memory();

/// Bytes that a case may have. @param jobs cases at once, at least one
std::uintmax_t memory_per_case(const CaseLimits& limits, unsigned jobs);

/// "10 s", "512 MiB": as the command line takes them.
std::string format_seconds(double seconds);
std::string format_bytes(std::uintmax_t bytes);

struct BatchProgress {
  std::size_t total = 0;          ///< cases
  std::size_t finished = 0;       ///< of them: computed now or found finished
  std::size_t reused = 0;         ///< found finished
  std::size_t reused_failed = 0;  ///< of those: without a result
  std::size_t failed = 0;         ///< without a result
};

struct BatchOptions {
  std::string folder;                                  ///< where results go; made if it does not exist
  unsigned jobs = 1;                                   ///< cases at once, at least one
  std::optional<Shard> shard;                          ///< nothing: all cases
  bool force = false;                                  ///< use a folder that holds other things
  std::function<void(const BatchProgress&)> progress;  ///< called after every case, by one thread at a time
  std::function<bool()> cancelled;                     ///< asked ten times a second if set; true ends the batch
  CaseLimits limits;
  StoredOutput stored_output = StoredOutput::series;
  bool retry_failed = false;  ///< compute cases again that had no result although nothing has changed
};

struct BatchOutcome {
  std::vector<CaseRecord> records;  ///< of the cases of the shard, in the suite's order
  BatchProgress progress;
};

/// Computes the cases that are not finished yet, each in a child process that ends with this one: a case that crashes or goes beyond
/// a limit is recorded as failed, and the others go on. The records and files are the same whatever options.jobs and however often
/// the batch was interrupted. Children are copies of the calling thread, as FencedWork tells.
/// @throws SystemError if the folder cannot be used; failures of cases are in their records
/// @throws Cancelled if options.cancelled says so: what is finished is kept
/// @throws std::invalid_argument if it would replace what it reads: see find_overwritten_input
BatchOutcome run_batch(const BatchPlan& plan, const BatchOptions& options);

/// What shards have computed. A case that none has is "missing". @throws SystemError as above
BatchOutcome collect_batch(const BatchPlan& plan, const std::string& folder);

}  // namespace balance
