#pragma once
/// Proofs that no choice of masses can meet a set of conditions: a combination of conditions whose left-hand side has a sign.

#include "balance/synthesis/conditions/conditions.hpp"

#include <optional>
#include <string>

namespace balance {

struct InfeasibilityCertificate {
  enum class Kind {
    sign,                ///< only quantities of one sign, with coefficients of one sign
    cone,                ///< positive for every distribution of mass (positive definite pseudo-inertia)
    bounds,              ///< positive for all values within the bounds of the free numbers
    product_relaxation,  ///< the same, with what squares of free numbers owe to the numbers
  };
  Kind kind = Kind::sign;
  VectorX combination;    ///< per condition: its factor
  VectorX coefficients;   ///< per parameter: the combined condition, largest coefficient's size 1 or the pivot's 1
  std::string statement;  ///< "coupler1.J + 0.852 coupler2.J = 0 cannot hold: both are positive"
};

/// For any masses whatever: the bodies are physical (masses and moments of inertia positive, pseudo-inertia positive
/// definite), counterweights, payloads and discs may vanish, stiffnesses are not negative.
/// Source: Farkas' lemma on the cone of pseudo-inertias.
std::optional<InfeasibilityCertificate> certify_infeasible(const Conditions& conditions, const Mechanism& mechanism);

/// Parameters that are affine in quantities with known bounds: values = constant + gradient · z, lower ≤ z ≤ upper.
struct BoundedParameters {
  VectorX constant;  ///< P
  MatrixX gradient;  ///< P × n
  VectorX lower, upper;
};

/// Within bounds, physical or not.
std::optional<InfeasibilityCertificate> certify_infeasible(const Conditions& conditions,
                                                           const BoundedParameters& parameters);

}  // namespace balance
