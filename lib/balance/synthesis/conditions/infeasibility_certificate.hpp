#pragma once
/// Proofs that no choice of masses can meet a set of conditions: a combination whose left-hand side has a definite
/// sign.

#include "balance/synthesis/conditions/conditions.hpp"

#include <optional>
#include <string>

namespace balance::conditions {

struct InfeasibilityCertificate {
  enum class Kind {
    sign,                ///< only quantities of one sign, with coefficients of one sign
    cone,                ///< positive for every distribution of mass (positive definite pseudo-inertia)
    bounds,              ///< positive for all values within the bounds of the free numbers
    product_relaxation,  ///< the same, with constraints that relate squares of free numbers to the numbers
  };
  Kind kind = Kind::sign;
  VectorX combination;    ///< per condition: its factor
  VectorX coefficients;   ///< per parameter: the combined condition; its first or largest coefficient is ±1
  std::string statement;  ///< "coupler1.J + 0.852 coupler2.J = 0 cannot hold: both are positive"
  /// Of the left-hand side, for `bounds` [unit of the parameter with coefficient ±1]; 0: only its sign is known.
  double minimum = 0;
};

/// For arbitrary masses: the bodies are physical (positive masses and moments of inertia, positive definite
/// pseudo-inertia); counterweights, payloads and discs may vanish; stiffnesses are nonnegative.
/// Source: Farkas' lemma on the cone of pseudo-inertias.
std::optional<InfeasibilityCertificate> certify_infeasible(const Conditions& conditions, const Mechanism& mechanism);

/// Parameters that are affine in bounded quantities: values = constant + gradient · z, lower ≤ z ≤ upper.
struct BoundedParameters {
  VectorX constant;  ///< P
  MatrixX gradient;  ///< P × n
  VectorX lower, upper;
};

/// For all values within bounds, physical or not.
std::optional<InfeasibilityCertificate> certify_infeasible(const Conditions& conditions,
                                                           const BoundedParameters& parameters);

}  // namespace balance::conditions
