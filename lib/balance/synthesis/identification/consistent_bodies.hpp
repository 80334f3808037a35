#pragma once
/// Physically consistent bodies: mass distributions that can exist, as near to those of the spec as the measurements
/// let them be.

#include "balance/foundation/base/types.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/synthesis/identification/unknown_parameters.hpp"

#include <string>
#include <vector>

namespace balance::identification {

/// Minimises
///
///     ½ |A x − b|² + w Σ_bodies [ tr(P₀⁻¹ P(x)) − log det P(x) ] + w/2 Σ_others ((x − x₀)/s)²
///
/// over all x with positive definite pseudo-inertia matrices P of the bodies and payloads. P = [Σ h; hᵀ m] holds second
/// moments Σ = tr(I)/2 − I, first moments h and the mass; in the plane, where only J is known of Σ, [J h; hᵀ m·1]. The
/// second term is the log-det divergence of the body from that of the spec, and the barrier that keeps P positive
/// definite. The last one holds what neither measurements nor bodies determine; s is large.
/// Source: T. Lee, P. M. Wensing, F. C. Park, Geometric robot dynamic identification: a convex programming approach, IEEE
/// Trans. Robotics 36(2), 2020. Damped Newton steps (the problem is convex and self-concordant).
struct ConsistentFit {
  VectorX x;           ///< per unknown [SI]
  MatrixX covariance;  ///< inverse of the Hessian: of unknowns, given that of the data
  bool is_converged = false;
  std::vector<std::string>
      repaired;  ///< bodies whose inertia in the spec is not that of a body; one of their size is meant
};

/// @param A,b weighted so that residuals have unit variance
/// @param weight w > 0
ConsistentFit fit_consistent_bodies(const Mechanism& mechanism, const std::vector<UnknownParameter>& unknowns,
                                    const MatrixX& A, const VectorX& b, double weight);

/// Smallest eigenvalue of a body's pseudo-inertia matrix relative to its largest one, scaled to the body's own size: positive
/// if such a body can exist.
double consistency_margin(const VectorX& inertial_parameters);

}  // namespace balance::identification
