#pragma once
/// What a suite comes to: its cases, the specs that they need, and what each case's result depends on.

#include "balance/interface/batch/suite.hpp"

#include <string>
#include <vector>

namespace balance {

// Which build of the program this is.

/// SHA-256 of the file that holds this code, the program or a library that it loaded. Another compiler, another option or one
/// changed line make another; the same build gives the same everywhere.
/// @throws SystemError if the file cannot be read
std::string hash_build();

/// A spec that some cases share, read once so that all of them see the same.
struct SpecSource {
  std::string path;                           ///< with the suite's folder
  std::string text;                           ///< empty if it cannot be read
  std::string failure_reason;                 ///< why it cannot be read; empty: it can
  std::vector<std::string> referenced_files;  ///< files that the spec is read with, its parts too
};

struct PlannedCase {
  std::size_t spec = 0;  ///< index into BatchPlan::specs
  /// SHA-256 of everything that the result depends on: the spec's text, the tables and parts that it is read with, the parameters,
  /// trajectory, controller, samples and design of the case, the program's version and build.
  std::string key;
};

struct BatchPlan {
  Suite suite;
  std::vector<SpecSource> specs;   ///< each once, in the order in which cases name them
  std::vector<PlannedCase> cases;  ///< one per suite.cases
};

/// Reads the specs. A spec that cannot be read is trouble of its cases, not of the plan.
/// @throws SystemError if the program cannot read itself
BatchPlan make_batch_plan(Suite suite);

/// A part of the cases, 1 ≤ index ≤ count.
struct Shard {
  int index = 1, count = 1;
};

/// Every case is in exactly one shard, which depends on the case's name and the number of shards alone.
bool is_in_shard(const std::string& case_name, const Shard& shard);

}  // namespace balance
