#pragma once
/// Values over time, as tables in the spec or beside it hold them.

#include "balance/expression/expression.hpp"

#include <vector>

namespace balance::specification {

/// Rows of values in SI at increasing times [s].
struct TimeTable {
  std::vector<Expression> time;
  std::vector<int> columns;                     ///< which of the possible columns there are, in the table's order
  std::vector<std::vector<Expression>> values;  ///< one row per time, one entry per column
};

}  // namespace balance::specification
