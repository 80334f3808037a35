#pragma once
/// Conditions of several load cases together: parameters of all cases, and conditions case by case.

#include "balance/mechanics/dynamics/dynamic_parameters.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/synthesis/conditions/conditions.hpp"

#include <cstddef>
#include <vector>

namespace balance::design {

/// Per case, the columns of its terms among those of all cases (disjoint_union): first by kind of owner, then by case.
std::vector<std::vector<int>> list_case_columns(const std::vector<std::vector<dynamics::Parameter>>& terms);

/// The conditions of every case by itself, stacked: the modular strategy cuts loops at the tool, and motions whose orders
/// are goals move one mechanism.
/// @param united disjoint_union of the cases' mechanisms
/// @param one the mechanism of a case: all have lists of the same lengths
Conditions derive_case_conditions(const Mechanism& united, const Mechanism& one, std::size_t cases,
                                  const std::vector<Goal>& goals, const ConditionOptions& options, bool is_modular);

}  // namespace balance::design
