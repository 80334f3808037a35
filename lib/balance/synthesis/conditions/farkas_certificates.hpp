#pragma once
/// What the parameters of things with mass have in common whatever their numbers: they are moments of a density that is nowhere
/// negative.
///
/// Σ cₚ πₚ of one thing is the integral of a polynomial in the place over its density (planar: c_m + c_mx x + c_my y +
/// c_J (x² + y²); spatial: the same with all six products), so it is positive for every density if and only if the
/// polynomial is not negative anywhere, that is, if its symmetric matrix Q(c) is positive semidefinite. Σ cₚ πₚ = tr(Q P) with
/// P the pseudo-inertia. Source: Wensing, Kim, Slotine, "Linear matrix inequalities for physically consistent inertial
/// parameter identification", 2018; Lasserre, "Moments, positive polynomials and their applications", 2010.

#include "balance/mechanics/dynamics/dynamic_parameters.hpp"

#include <optional>
#include <utility>
#include <vector>

namespace balance {

/// Whether a parameter's own sign is known.
enum class ParameterSign {
  positive,      ///< mass and moments of inertia of a body
  not_negative,  ///< those of things that may vanish; stiffnesses
  indefinite,
};

ParameterSign parameter_sign(const Parameter& parameter);
/// First moments of discs, which are about their CoM.
bool is_always_zero(const Parameter& parameter);

/// One matrix that must be positive semidefinite: Q(c) = Σ c[p] E over the parameters p of one thing.
struct PseudoInertiaBlock {
  struct Term {
    Eigen::Index parameter = 0;
    MatrixX matrix;
  };
  Eigen::Index size = 0;
  bool is_body = false;  ///< its density cannot be zero everywhere; or it is the known terms, which are what they are
  std::vector<Term> terms;

  MatrixX matrix(const VectorX& coefficients) const;
  /// The row by which the coefficients give uᵀ Q(c) v.
  VectorX bilinear_form_row(const VectorX& u, const VectorX& v, Eigen::Index parameters) const;
};

/// The functionals that no physical parameters make negative: every block positive semidefinite, and no parameter that has any
/// sign by itself (the products of a spring's ends) or whose value is open (known terms that free numbers change).
struct PseudoInertiaCone {
  std::vector<PseudoInertiaBlock> blocks;
  std::vector<Eigen::Index> excluded;  ///< their coefficients must be zero

  explicit PseudoInertiaCone(const std::vector<Parameter>& parameters);
};

// Combinations of conditions that cannot vanish (Farkas' lemma).
// Conditions and parameters are in natural units here, so that all numbers are comparable and have the size of one.

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
