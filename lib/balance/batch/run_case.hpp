#pragma once
/// One case of a suite: read, balanced if wanted, simulated, written.

#include "balance/batch/case_record.hpp"
#include "balance/batch/plan.hpp"

#include <string>

namespace balance {

/// Computes a case and writes its result into the folder, and its balanced spec if it is designed. Whatever goes wrong is told by
/// the record; nothing is thrown. May run in several threads at once.
CaseRecord run_case(const Plan& plan, std::size_t index, const std::string& folder);

}  // namespace balance
