#pragma once
/// Names of statuses of conditions and designs.

#include "balance/synthesis/conditions/conditions.hpp"
#include "balance/synthesis/design/solve_design.hpp"

#include <string>
#include <vector>

namespace balance::design {

const char* name_of(ConditionsStatus status);  ///< "done", "rank-unclear", …
const char* name_of(DesignStatus status);      ///< "balanced", "compromise", …
const char* name_of(Optimality optimality);    ///< "proved-best", "local-best", …
const char* name_of(DesignMethod method);      ///< "affine", "polynomial", …

/// All words for statuses and optimality of designs, each once.
const std::vector<std::string>& design_verdict_words();

}  // namespace balance::design
