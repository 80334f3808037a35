#pragma once
/// Conditions of the modular strategy for several load cases.

#include "balance/mechanics/model/mechanism.hpp"
#include "balance/synthesis/conditions/conditions.hpp"

#include <vector>

namespace balance::design {

/// The conditions of every case by itself, stacked. The strategy cuts loops at the tool, and each case has its own.
/// @param united disjoint_union of the cases' mechanisms
/// @param one the mechanism of a case: all have lists of the same lengths
Conditions derive_modular_case_conditions(const Mechanism& united, const Mechanism& one, const std::vector<Goal>& goals,
                                          const ConditionOptions& options);

}  // namespace balance::design
