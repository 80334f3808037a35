#pragma once
/// One case of a suite: read, balanced if wanted, simulated, written.

#include "balance/batch/case_record.hpp"
#include "balance/batch/plan.hpp"

#include <string>

namespace balance {

/// What is kept of a case.
enum class Keep {
  series,        ///< its samples, in a file, and its metrics
  metrics_only,  ///< no samples
};

/// Computes a case and writes its result into the folder, and its balanced spec if it is designed. Whatever goes wrong is told by
/// the record, but for a lack of memory. May run in several threads at once.
/// @throws std::bad_alloc
CaseRecord run_case(const Plan& plan, std::size_t index, const std::string& folder, Keep keep = Keep::series);

}  // namespace balance
