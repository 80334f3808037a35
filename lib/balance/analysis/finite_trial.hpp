#pragma once
/// Trials of designs whose expressions all have a value.

#include "balance/study/design_space.hpp"

#include <string>

namespace balance {

/// The first fault (validate) of a mechanism, a sentence; empty: there is none.
std::string find_validation_issue(const Mechanism& mechanism);

/// The mechanism and its trajectories at values of the free numbers.
/// @throws SpecError if an expression of the mechanism has no value there
DesignInstance instantiate_checked(const DesignSpace& space, const VectorX& x);

}  // namespace balance
