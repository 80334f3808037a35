#pragma once
/// Trials of designs whose expressions all have a value.

#include "balance/study/design_space.hpp"

namespace balance {

/// The mechanism and its trajectories at values of the free numbers.
/// @throws SpecError if an expression of the mechanism has no value there
Trial finite_trial(const DesignSpace& space, const VectorX& x);

}  // namespace balance
