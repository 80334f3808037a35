#pragma once
/// The cases of a summary as rows of cells, for text and Markdown. Private to batch.

#include "balance/batch/summary.hpp"
#include "balance/write/table.hpp"

namespace balance {

/// Status, peak and rms of the torque, the shaking force and the shaking moment, and the peaks' ratios to the baseline's where
/// there is one. Mass added by designs where there are designs.
TextTable case_table(const BatchSummary& summary);

/// "3 cases: 2 done, 1 failed; 4 of 5 requirements hold"
std::string format_summary_line(const BatchSummary& summary);

const char* requirement_status_name(RequirementOutcome::Status status);  ///< "holds", "missed", …

/// "peak(shaking_force) <= base [cycloid]": the requirement and the case that it is about.
std::string requirement_title(const RequirementOutcome& one);

}  // namespace balance
