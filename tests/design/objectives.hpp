#pragma once
/// Objectives whose best values are known by hand.

#include "balance/synthesis/design/solve_design.hpp"

namespace design_tests {

using namespace balance;

/// Σ wᵢ pᵢ, or with `squared` Σ wᵢ pᵢ², over the parameters of one symbol and kind of bearer.
inline Objective sum_of(const Mechanism& mechanism, ParameterOwner bearer, const std::string& symbol,
                        bool squared = false) {
  VectorX weights = VectorX::Zero(parameter_values(mechanism).size());
  const auto parameters = list_parameters(mechanism);
  for (std::size_t p = 0; p < parameters.size(); ++p)
    if (parameters[p].owner_kind == bearer && parameters[p].symbol == symbol) weights[static_cast<Eigen::Index>(p)] = 1;
  Objective objective;
  objective.name = "sum";
  objective.is_convex = true;
  objective.is_secondary = !squared;
  objective.of_parameters = [weights, squared](const VectorX& pi, VectorX* gradient) {
    if (gradient != nullptr) *gradient = squared ? VectorX(2 * weights.cwiseProduct(pi)) : weights;
    return squared ? weights.dot(pi.cwiseAbs2()) : weights.dot(pi);
  };
  return objective;
}

}  // namespace design_tests
