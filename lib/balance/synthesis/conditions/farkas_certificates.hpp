#pragma once
/// Physical consistency of inertial parameters: whatever their values, they are moments of a nonnegative density.
///
/// For one body, attachment or disc, Σ cₚ πₚ is the integral of a polynomial in position, weighted with the density
/// (planar: c_m + c_mx x + c_my y + c_J (x² + y²); spatial: the same with all six products). It is nonnegative for
/// every density if and only if the polynomial is nonnegative everywhere, that is, if its symmetric matrix Q(c) is
/// positive semidefinite. Σ cₚ πₚ = tr(Q P) with P the pseudo-inertia. Source: Wensing, Kim, Slotine, "Linear matrix
/// inequalities for physically consistent inertial parameter identification", 2018; Lasserre, "Moments, positive
/// polynomials and their applications", 2010.

#include "balance/mechanics/dynamics/dynamic_parameters.hpp"

#include <optional>
#include <utility>
#include <vector>

namespace balance::conditions {

/// What is known about a parameter's sign.
enum class ParameterSign {
  positive,      ///< mass and moments of inertia of a body
  not_negative,  ///< those of elements that may vanish; stiffnesses
  indefinite,
};

ParameterSign parameter_sign(const dynamics::Parameter& parameter);
/// True for first moments of discs, which are about their CoM.
bool is_always_zero(const dynamics::Parameter& parameter);

/// One matrix that must be positive semidefinite: Q(c) = Σ c[p] E over the parameters p of one owner.
struct PseudoInertiaBlock {
  struct Term {
    Eigen::Index parameter = 0;
    MatrixX matrix;
  };
  Eigen::Index size = 0;
  bool is_body = false;  ///< its density cannot vanish everywhere; true for known terms, too
  std::vector<Term> terms;

  MatrixX matrix(const VectorX& coefficients) const;
  /// The row whose product with the coefficients is uᵀ Q(c) v.
  VectorX bilinear_form_row(const VectorX& u, const VectorX& v, Eigen::Index parameters) const;
};

/// The functionals that are nonnegative for all physical parameters: every block is positive semidefinite, and
/// parameters of indefinite sign (products of a spring's ends) or open value (known terms that free numbers change) do
/// not occur.
struct PseudoInertiaCone {
  std::vector<PseudoInertiaBlock> blocks;
  std::vector<Eigen::Index> excluded;  ///< their coefficients must be zero

  explicit PseudoInertiaCone(const std::vector<dynamics::Parameter>& parameters);
};

// Combinations of conditions that cannot vanish (Farkas' lemma).
// Conditions and parameters are in natural units here, so that all numbers are comparable and of order one.

/// c = rowsᵀ λ.
struct FarkasCertificate {
  VectorX combination;   ///< λ
  VectorX coefficients;  ///< c, with exact zeros
};

/// Coefficients of this size, in natural units and relative to one, are round-off.
inline constexpr double certificate_coefficient_tolerance = 1e-9;

/// Returns a combination without parameters of indefinite sign, without negative coefficients, and with a body's mass
/// or moment of inertia among its terms: the one with the fewest terms that a few linear programs find.
std::optional<FarkasCertificate> find_sign_certificate(const MatrixX& rows,
                                                       const std::vector<dynamics::Parameter>& parameters);

/// Returns a combination in the cone that is nonzero for some body. Its matrices are positive semidefinite up to 1e-10.
std::optional<FarkasCertificate> find_cone_certificate(const MatrixX& rows, const PseudoInertiaCone& cone);

/// Returns λ of minimum Σ|λ| with λᵀ(constant + gradient z) ≥ 1 for all z in the box lower ≤ z ≤ upper.
std::optional<VectorX> find_bounds_certificate(const VectorX& constant, const MatrixX& gradient, const VectorX& lower,
                                               const VectorX& upper);

}  // namespace balance::conditions
