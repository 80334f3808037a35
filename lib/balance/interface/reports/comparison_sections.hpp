#pragma once
/// Comparisons of runs as text, Markdown, CSV, JSON and JUnit XML.

#include "balance/interface/comparison/comparison.hpp"
#include "balance/interface/comparison/requirement_verdict.hpp"
#include "balance/interface/files/json.hpp"
#include "balance/interface/files/text_table.hpp"
#include "balance/interface/reports/junit.hpp"

#include <string>
#include <vector>

namespace balance::reports {

// Comparisons and verdicts as JSON and JUnit XML.

/// One object: runs, quantities with figures, ratios and differences per run, notes, requirements; ends with a line
/// feed. Missing values are null.
std::string comparison_json(const comparison::ComparedRuns& compared,
                            const std::vector<comparison::RequirementVerdict>& verdicts);

/// One test case per verdict, named after the requirement; its group is the run.
JunitSuite make_verdict_suite(const std::string& name, const std::vector<comparison::RequirementVerdict>& verdicts);

// Comparisons for people, as text, Markdown and CSV.

/// Which quantities to show: the main ones (torque and power of each actuator, shaking force and moment,
/// the worst reactions), or all.
enum class QuantitySelection { main, all };

/// Tables, notes and verdicts, six significant digits. A verdict stays on one line.
/// @param width columns for tables and notes
std::string comparison_text(const comparison::ComparedRuns& compared,
                            const std::vector<comparison::RequirementVerdict>& verdicts, QuantitySelection selection,
                            std::size_t width = files::default_text_width);

/// The same as Markdown.
std::string comparison_markdown(const comparison::ComparedRuns& compared,
                                const std::vector<comparison::RequirementVerdict>& verdicts,
                                QuantitySelection selection);

/// Every figure of every quantity, one per line: `quantity,unit,figure,run,value,ratio`, 17 significant digits; missing
/// values are empty. Figures are peak, peak_time, rms, mean, range, largest_difference, difference_time,
/// rms_difference; of energy, total.
std::string comparison_csv(const comparison::ComparedRuns& compared);

/// "ok     <requirement> [run]: …" or "FAILED <requirement> [run]: …", ending with describe_verdict().
std::string format_verdict_line(const comparison::RequirementVerdict& verdict);

/// All verdicts, one per line.
std::string format_verdicts(const std::vector<comparison::RequirementVerdict>& verdicts);

}  // namespace balance::reports
