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
enum class ShownQuantities { main, all };

struct TitledTable {
  std::string title;
  Table table;
};

/// The runs; per figure every quantity with its ratio to the base; the differences; the energy.
std::vector<TitledTable> list_tables(const ComparedRuns& compared, ShownQuantities shown);

/// One row per verdict.
Table verdict_table(const std::vector<Verdict>& verdicts);

/// "3 of 4 requirements hold"
std::string count_text(const std::vector<Verdict>& verdicts);

}  // namespace balance
