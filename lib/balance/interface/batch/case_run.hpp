#pragma once
/// One case of a suite: read, balanced if wanted, simulated, written.

#include "balance/interface/batch/batch_plan.hpp"
#include "balance/interface/batch/case_record.hpp"
#include "balance/interface/specification/read_spec.hpp"

#include <optional>
#include <string>

namespace balance {

/// What is kept of a case.
enum class StoredOutput {
  series,        ///< its samples, in a file, and its metrics
  metrics_only,  ///< no samples
};

/// The spec of the last case, parsed: the next one often has the same.
struct ParsedSpecCache {
  std::size_t index = 0;  ///< into BatchPlan::specs
  std::optional<SpecDocument> document;
};

/// Computes a case and writes its result into the folder, and its balanced spec if it is designed. Whatever goes wrong is told by
/// the record, but for a lack of memory. May run in several threads at once, each with a `last` of its own.
/// @throws std::bad_alloc
CaseRecord run_case(const BatchPlan& plan, std::size_t index, const std::string& folder, StoredOutput keep,
                    ParsedSpecCache& last);

}  // namespace balance
