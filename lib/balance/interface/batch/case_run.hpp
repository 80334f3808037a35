#pragma once
/// One case of a suite: reads its spec, balances it if requested, simulates it and writes the result.

#include "balance/interface/batch/batch_plan.hpp"
#include "balance/interface/batch/case_record.hpp"
#include "balance/interface/specification/read_spec.hpp"

#include <optional>
#include <string>

namespace balance::batch {

/// Output that is kept of a case.
enum class StoredOutput {
  series,        ///< its samples, in a file, and its metrics
  metrics_only,  ///< no samples
};

/// The parsed spec of the last case: the next one often has the same.
struct ParsedSpecCache {
  std::size_t index = 0;  ///< into BatchPlan::specs
  std::optional<specification::SpecDocument> document;
};

/// Computes a case and writes its result to the folder, with its balanced spec if it is designed. The record reports
/// all failures except a lack of memory. May run in several threads at once, each with a `spec_cache` of its own.
/// @throws std::bad_alloc
CaseRecord run_case(const BatchPlan& plan, std::size_t index, const std::string& folder, StoredOutput stored_output,
                    ParsedSpecCache& spec_cache);

}  // namespace balance::batch
