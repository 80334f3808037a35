#pragma once
/// What the torques of a mechanism's tree are as matrix times inertial parameters.

#include "balance/formulas/equations.hpp"

namespace balance::formulas {

/// τ = Y π + springs. Y has the accelerations and rates of the columns as symbols.
struct SymbolicRegressor {
  std::vector<int> rates, accelerations;  ///< symbols, per column
  std::vector<int> parameters;            ///< symbols of π, in the order of list_parameters
  Matrix Y;                               ///< columns × parameters
};

/// @param equations of a tree with inertial parameters about the bodies' origins, in which they are linear
SymbolicRegressor derive_regressor(Ring& ring, const SymbolicEquations& equations);

/// `1 m1, 2 mx1, …`: what the columns of Y belong to.
std::string parameter_text(const Ring& ring, const SymbolicRegressor& regressor);

}  // namespace balance::formulas
