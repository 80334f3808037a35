#pragma once
/// Derivatives of the results of InverseDynamics at a state, exact to round-off, with respect to the state's own
/// variables and to variables of the mechanism. With loops, the configuration follows the variables (implicit function
/// theorem) while the independent coordinates are held.

#include "balance/mechanics/derivatives/mechanism_variables.hpp"
#include "balance/mechanics/dynamics/inverse_dynamics.hpp"

#include <variant>
#include <vector>

namespace balance::derivatives {

/// A variable of the state: the k-th independent coordinate, its rate or its acceleration.
struct StateVariable {
  enum class Kind { q, dq, ddq };
  Kind kind = Kind::q;
  int index = 0;
};

using DifferentiationVariable = std::variant<StateVariable, MechanismVariable>;

struct StateGradient {
  Sample sample;                    ///< as InverseDynamics::at returns it
  std::vector<Sample> derivatives;  ///< per requested variable: derivatives of all values of the sample
  /// Per requested variable: if not empty, its derivatives are those of the least-squares solution of the loop
  /// closures.
  std::vector<ClosureGaps> closure_gaps;
};

/// @param inverse_dynamics moved to the state, as by at()
/// @param variables any variables, in any order
/// @param time at which time-dependent loads are evaluated [s]
/// @return the outcome of at(); actuation_singularity if the efforts have no derivatives there
/// @throws std::invalid_argument as at(), and if a requested variable does not exist
Expected<StateGradient> differentiate_state(InverseDynamics& inverse_dynamics, const VectorX& q, const VectorX& dq,
                                            const VectorX& ddq, const std::vector<DifferentiationVariable>& variables,
                                            double time = 0);

}  // namespace balance::derivatives

namespace balance {

using derivatives::differentiate_state;
using derivatives::StateGradient;
using derivatives::StateVariable;

}  // namespace balance
