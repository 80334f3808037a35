#pragma once
/// Trials of designs whose expressions all have a value.

#include "balance/study/design_space.hpp"

#include <string>

namespace balance {

/// The first fault (validate) of a mechanism, a sentence; empty: there is none.
std::string first_fault(const Mechanism& mechanism);

/// The mechanism and its trajectories at values of the free numbers.
/// @throws SpecError if an expression of the mechanism has no value there
Trial finite_trial(const DesignSpace& space, const VectorX& x);

}  // namespace balance
