#pragma once
/// The cases of a summary as rows of cells, for text and Markdown. Private to batch.

#include "balance/batch/summary.hpp"
#include "balance/write/table.hpp"

namespace balance {

/// Status, peak and rms of the torque, the shaking force and the shaking moment, and the peaks' ratios to the baseline's where
/// there is one. Mass added by designs where there are designs.
Table case_table(const Summary& summary);

/// "3 cases: 2 done, 1 failed; 4 of 5 requirements hold"
std::string in_one_line(const Summary& summary);

const char* name_of(RequirementOutcome::Status status);  ///< "holds", "missed", …

/// "peak(shaking_force) <= base [cycloid]": the requirement and the case that it is about.
std::string title_of(const RequirementOutcome& one);

}  // namespace balance
