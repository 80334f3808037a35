#pragma once
/// Derivatives of what InverseDynamics finds at a state, exact to round-off: with respect to the state's own numbers and to numbers of
/// the mechanism. With loops the configuration follows the numbers (implicit function theorem), the independent coordinates staying.

#include "balance/mechanics/derivatives/mechanism_variables.hpp"
#include "balance/mechanics/dynamics/inverse_dynamics.hpp"

#include <variant>
#include <vector>

namespace balance {

/// A number of the state: the k-th independent coordinate, its rate or its acceleration.
struct StateVariable {
  enum class Kind { q, dq, ddq };
  Kind kind = Kind::q;
  int index = 0;
};

using DifferentiationVariable = std::variant<StateVariable, MechanismVariable>;

struct StateGradient {
  Sample sample;                    ///< as InverseDynamics::at finds it
  std::vector<Sample> derivatives;  ///< per number wanted: what each of the sample's numbers changes by per unit of it
  /// Per number wanted: where there are any, its derivatives are of what least squares leave.
  std::vector<ClosureGaps> closure_gaps;
};

/// @param door goes to the state, as at() does
/// @param wanted any numbers, in any order
/// @param time of loads that change with it [s]
/// @return the outcome of at()
/// @throws std::invalid_argument as at(), and if a number wanted does not exist
Expected<StateGradient> differentiate_state(InverseDynamics& door, const VectorX& q, const VectorX& dq,
                                            const VectorX& ddq, const std::vector<DifferentiationVariable>& wanted,
                                            double time = 0);

}  // namespace balance
