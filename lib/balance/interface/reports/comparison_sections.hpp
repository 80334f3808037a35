#pragma once
/// Comparisons as text, Markdown and comma-separated values.

#include "balance/interface/comparison/comparison.hpp"
#include "balance/interface/comparison/requirement_verdict.hpp"
#include "balance/interface/files/json.hpp"
#include "balance/interface/files/text_table.hpp"
#include "balance/interface/reports/junit.hpp"

#include <string>
#include <vector>

namespace balance {

// Comparisons and verdicts as JSON and JUnit XML for programs.

/// One object: runs, quantities with figures, ratios and differences per run, notes, requirements; ends with a line feed. What is
/// missing is null.
std::string comparison_json(const ComparedRuns& compared, const std::vector<RequirementVerdict>& verdicts);

/// One test case per verdict: its name is the requirement, its group the run.
JunitSuite make_verdict_suite(const std::string& name, const std::vector<RequirementVerdict>& verdicts);

// What a comparison shows people, whatever the format: tables under titles.

/// Which quantities are shown: the ones most asked for (torque and power of each actuator, shaking force and moment, the worst
/// reactions), or all that there are.
enum class QuantitySelection { main, all };

struct TitledTextTable {
  std::string title;
  TextTable table;
};

/// The runs; per figure every quantity with its ratio to the base; the differences; the energy.
std::vector<TitledTextTable> make_comparison_tables(const ComparedRuns& compared, QuantitySelection shown);

/// One row per verdict.
TextTable verdict_table(const std::vector<RequirementVerdict>& verdicts);

/// "3 of 4 requirements hold"
std::string format_verdict_count(const std::vector<RequirementVerdict>& verdicts);

/// Tables, notes and verdicts, six significant digits.
std::string comparison_text(const ComparedRuns& compared, const std::vector<RequirementVerdict>& verdicts,
                            QuantitySelection shown);

/// The same as Markdown.
std::string comparison_markdown(const ComparedRuns& compared, const std::vector<RequirementVerdict>& verdicts,
                                QuantitySelection shown);

/// Every figure of every quantity, one per line: `quantity,unit,figure,run,value,ratio`, 17 significant digits; empty where there is
/// none. Figures are peak, peak_time, rms, mean, range, largest_difference, difference_time, rms_difference.
std::string comparison_csv(const ComparedRuns& compared);

/// "ok     <requirement> [run]: holds: …" or "FAILED <requirement> [run]: …", as describe_verdict() ends.
std::string format_verdict_line(const RequirementVerdict& verdict);

/// The verdicts alone, one a line.
std::string format_verdicts(const std::vector<RequirementVerdict>& verdicts);

// A verdict as a piece of a JSON document.

/// What is no number is null.
Json verdict_json(const RequirementVerdict& verdict);

}  // namespace balance
