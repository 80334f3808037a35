#pragma once
/// Comparisons as text, Markdown and comma-separated values.

#include "balance/present/comparison_tables.hpp"

#include <string>

namespace balance {

/// Tables, notes and verdicts, six significant digits.
std::string comparison_text(const ComparedRuns& compared, const std::vector<RequirementVerdict>& verdicts,
                            QuantitySelection shown);

/// The same as Markdown.
std::string comparison_markdown(const ComparedRuns& compared, const std::vector<RequirementVerdict>& verdicts,
                                QuantitySelection shown);

/// Every figure of every quantity, one per line: `quantity,unit,figure,run,value,ratio`, 17 significant digits; empty where there is
/// none. Figures are peak, peak_time, rms, mean, range, largest_difference, difference_time, rms_difference.
std::string comparison_csv(const ComparedRuns& compared);

/// "ok     <requirement> [run]: holds: …" or "FAILED <requirement> [run]: …", as in_words ends.
std::string format_verdict_line(const RequirementVerdict& verdict);

/// The verdicts alone, one a line.
std::string format_verdicts(const std::vector<RequirementVerdict>& verdicts);

}  // namespace balance
