#pragma once
/// What to balance for, as specs and suites say it. Private to the readers.

#include "balance/spec/cursor.hpp"
#include "balance/study/goal.hpp"

#include <vector>

namespace balance::specification {

/// One goal or a list of different ones; a fault at the cursor's place if it is neither.
std::vector<Goal> read_goals(const SpecCursor& at);

}  // namespace balance::specification
