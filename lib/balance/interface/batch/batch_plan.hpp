#pragma once
/// The plan of a suite: its cases, the specs that they need, and what each case's result depends on.

#include "balance/interface/batch/suite.hpp"

#include <string>
#include <vector>

namespace balance::batch {

// Identity of this build of the program.

/// SHA-256 of the file that contains this code, the program or a library that it loaded. Another compiler, option or
/// source line changes it; the same build gives the same hash everywhere.
/// @throws SystemError if the file cannot be read
std::string hash_build();

/// A spec shared by cases, read once so that all of them see the same text.
struct SpecSource {
  std::string path;                           ///< including the suite's folder
  std::string text;                           ///< empty if it cannot be read
  std::string failure_reason;                 ///< why it cannot be read; otherwise empty
  std::vector<std::string> referenced_files;  ///< files that the spec refers to, including its parts
};

struct PlannedCase {
  std::size_t spec = 0;  ///< index into BatchPlan::specs
  /// SHA-256 of everything that the result depends on: the spec's text, the tables and parts that it refers to, the
  /// parameters, trajectory, controller, samples and design of the case, its kind, state, points and solved
  /// parameters, the program's version and build. Figures are not part of it: a record must answer them.
  std::string key;
  std::vector<comparison::FigureReference> figures;  ///< that the suite asks of the case
  bool asks_for_verdict = false;                     ///< as the function of that name
};

struct BatchPlan {
  Suite suite;
  std::vector<SpecSource> specs;   ///< each once, in the order of first use
  std::vector<PlannedCase> cases;  ///< one per suite case
};

/// Reads the specs. A spec that cannot be read fails its cases, not the plan.
/// @throws SystemError if the program cannot read its own file
BatchPlan make_batch_plan(Suite suite);

/// A subset of the cases, 1 ≤ index ≤ count.
struct Shard {
  int index = 1, count = 1;
};

/// Every case is in exactly one shard, which depends only on the case's name and the number of shards.
bool is_in_shard(const std::string& case_name, const Shard& shard);

}  // namespace balance::batch
