#pragma once
/// Base parameters: the combinations of inertial parameters that the equation of motion depends on.

#include "balance/synthesis/conditions/conditions.hpp"

namespace balance {

/// Of what an identification, or any measurement of efforts and motions, can tell. Each row of the matrix times π is one of them,
/// solved for its pivot: that parameter grouped with others that occur only together with it. A parameter without a coefficient
/// occurs nowhere. Springs, loads and friction are left out.
/// @param seed of the configurations
/// @return conditions without goals; mismatch never
Conditions compute_base_parameters(const Mechanism& mechanism, std::uint64_t seed = 1);

}  // namespace balance
