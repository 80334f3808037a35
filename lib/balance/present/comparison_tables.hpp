#pragma once
/// What a comparison shows people, whatever the format: tables under titles.

#include "balance/compare/comparison.hpp"
#include "balance/compare/verdict.hpp"
#include "balance/write/table.hpp"

#include <string>
#include <vector>

namespace balance {

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

}  // namespace balance
