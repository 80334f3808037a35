#pragma once
/// Combinations of conditions that cannot vanish (Farkas' lemma). Private to conditions.
///
/// Conditions and parameters are in natural units here, so that all numbers are comparable and have the size of one.

#include "balance/conditions/mass_cone.hpp"

#include <optional>

namespace balance {

/// c = rowsᵀ λ.
struct FarkasCertificate {
  VectorX combination;   ///< λ
  VectorX coefficients;  ///< c, with exact zeros
};

/// Coefficients of this size, in natural units and beside one, are round-off.
inline constexpr double certificate_coefficient_tolerance = 1e-9;

/// A combination with no parameter whose sign is unknown, no negative coefficient, and a body's mass or moment of inertia among
/// its terms; of several the one with fewest terms that a few linear programs find.
std::optional<FarkasCertificate> find_sign_certificate(const MatrixX& rows, const std::vector<Parameter>& parameters);

/// A combination that lies in the cone and is not zero for all bodies. Its matrices are positive semidefinite up to 1e-10.
std::optional<FarkasCertificate> find_cone_certificate(const MatrixX& rows, const PseudoInertiaCone& cone);

/// A combination that is positive for all z in a box: λᵀ(constant + gradient z) ≥ 1 with lower ≤ z ≤ upper, of least Σ|λ|.
std::optional<VectorX> find_bounds_certificate(const VectorX& constant, const MatrixX& gradient, const VectorX& lower,
                                               const VectorX& upper);

}  // namespace balance
