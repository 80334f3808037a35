#pragma once
/// Which figures a trade-off is between.

#include "balance/spec/draft.hpp"

namespace balance::specification {

/// A list of two or three figures, each as `minimize` has it, or {of: such a list, points: how many designs}.
ParetoRequest read_pareto_request(const SpecCursor& at, StudyBuilder& draft);

}  // namespace balance::specification
