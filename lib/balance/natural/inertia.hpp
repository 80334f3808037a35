#pragma once
/// A body's inertia distributed over points of it: kinetic energy ½ żᴴ M ż with M constant, re-derived from M = ∫ Nᴴ N dm
/// (P3 eq. 1–14 have misprints). Private to natural.

#include "balance/natural/form.hpp"

namespace balance::natural {

/// About the origin of the body's frame.
struct NaturalInertia {
  double mass = 0;
  Complex first_moment;      ///< ∫ r dm
  double second_moment = 0;  ///< ∫ |r|² dm

  NaturalInertia& operator+=(const NaturalInertia& other);
};

/// Weights of two points for a place of the body: r ↦ (1 − κ) A + κ B with κ = (r − a) / (b − a). A similarity: exact for any
/// planar body, whose inertia M carries whole. The 2×2 complex matrix is P3 eq. 1–5 (2×2 real blocks [Re −Im; Im Re]).
/// @param a, b places of the points, different
Eigen::Matrix2cd two_point_mass(const NaturalInertia& inertia, Complex a, Complex b);

/// ∫ [1 x y]ᵀ [1 x y] dm: what an affine distribution needs. A rigid motion shows only Sxx + Syy, so any body with the given
/// trace is as good as the real one: this one has the same second moments about every axis through its centre of mass.
Matrix3 isotropic_moments(const NaturalInertia& inertia);

/// Weights linear in x and y that are one at their own point and zero at the others (barycentric); M is the real 3×3 matrix
/// whose entries multiply 2×2 identities, P3 eq. 6–14 as corrected.
/// @param a, b, c corners of a triangle
Matrix3 three_point_mass(const Matrix3& moments, Complex a, Complex b, Complex c);

}  // namespace balance::natural
