#pragma once
/// What `batch` is asked to do.

#include "command.hpp"

#include "balance/batch/run.hpp"

#include <optional>
#include <string>

namespace balance::app {

struct BatchCommandOptions {
  std::string suite;
  std::string output;                     ///< folder; empty: the suite's stem with `-results`, in the current folder
  unsigned jobs = 0;                      ///< 0: all cores
  std::string shard;                      ///< "i/n"
  std::string case_timeout, case_memory;  ///< empty: as the library has it
  bool metrics_only = false;
  bool retry_failed = false;
  bool merge = false;
  bool list = false;
  bool force = false;
  bool json = false;
  bool quiet = false;
};

void add_batch_options(CLI::App& parser, BatchCommandOptions& options);

/// @throws UsageError for text that is not i/n
std::optional<Shard> parse_shard(const std::string& text);

/// Where the results go.
std::string choose_output_folder(const BatchCommandOptions& options);

/// What the library is to do, without progress. @throws UsageError for a limit that is none
BatchOptions make_batch_options(const BatchCommandOptions& options);

}  // namespace balance::app
