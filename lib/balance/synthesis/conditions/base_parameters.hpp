#pragma once
/// Base parameters: the combinations of inertial parameters that the equation of motion depends on.

#include "balance/synthesis/conditions/conditions.hpp"

namespace balance::conditions {

/// The combinations of parameters that measured efforts and motions can identify. Each row of the matrix times π is one
/// base parameter, solved for its pivot: that parameter grouped with those that occur only together with it. A
/// parameter without a coefficient does not affect the equation of motion. Springs, loads and friction are left out.
/// @param seed of the random configurations
/// @return conditions without goals; the status is never mismatch
Conditions compute_base_parameters(const Mechanism& mechanism, std::uint64_t seed = 1);

}  // namespace balance::conditions
