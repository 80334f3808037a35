#pragma once
/// Comparisons and verdicts as JSON and JUnit XML for programs.

#include "balance/compare/comparison.hpp"
#include "balance/compare/verdict.hpp"
#include "balance/present/junit.hpp"

#include <string>
#include <vector>

namespace balance {

/// One object: runs, quantities with figures, ratios and differences per run, notes, requirements; ends with a line feed. What is
/// missing is null.
std::string comparison_json(const ComparedRuns& compared, const std::vector<RequirementVerdict>& verdicts);

/// One test case per verdict: its name is the requirement, its group the run.
JunitSuite make_verdict_suite(const std::string& name, const std::vector<RequirementVerdict>& verdicts);

}  // namespace balance
