#pragma once
/// The dual of the least added mass at given lengths: a virtual linkage.
///
/// The least mass that balances a linkage is a linear program in the counterweights' masses and first moments. Its dual
/// has one complex number η_k per moving vector, a direction of any magnitude, with Σ_k L_jk η_k = 0 in every closure (the
/// ground's vectors vanish). A place q on a body with direction k then has the virtual height
///
///     h(q) = Re(Σ_i R_i η_i + q η_k),
///
/// and if h ≤ 1 at every corner of every counterweight's box, no counterweights lighter than −Σ m h over the fixed
/// masses balance the linkage. With the unknowns w_k = s_k η_k, where s_k is the length of link k, and after each
/// closure is solved for one of its vectors, every such inequality times a product of lengths is polynomial in
/// the lengths and linear in w.
///
/// Moments. The angular momentum of a mass at Σ_u a_u z_u is ½ Im Σ_uv ā_u a_v A_uv, where A_uv = z̄_u dz_v − z_v dz̄_u, of
/// which a spin θ̇_k is the part ½ Im A_kk. Each closure Σ_v L_v z_v = 0 (with the ground's constant, z_0 = 1) implies
/// Σ_v L_v A_uv = 0 for every u, and general lengths have no other relations. The dual therefore has a Hermitian form
/// G_uv of which every closure is in the kernel, with G_uv = 0 for u = v and purely imaginary else where z_u and z_v are
/// real; it adds Re Σ_uv ā_u a_v G_uv to the height of a mass and Σ_k spin_k G_kk to that of an inertia. It is given by
/// its values on the vectors that are no pivots, as each place is by these, and by W_uv = s_u s_v G_uv.

#include "balance/synthesis/certificate/bernstein_form.hpp"
#include "balance/synthesis/certificate/loop_closures.hpp"

namespace balance::certificate {

/// scale · h = Σ_j coefficients[j] w_j.
struct VirtualHeight {
  LengthPolynomial scale;
  std::vector<LengthPolynomial> coefficients;  ///< real, one per unknown
};

/// scale · h = Σ_b f_b Σ_j coefficients[b][j] w_j of what is at a place (x, y) and turns in a ratio r, with the
/// functions f = 1, x, y, x² + y², r; of a coordinate that is not free, the constant part contains it.
struct PlacedHeight {
  static constexpr std::size_t constant = 0, x = 1, y = 2, square = 3, ratio = 4, count = 5;
  LengthPolynomial scale;
  std::array<std::vector<LengthPolynomial>, count> coefficients;  ///< real, one per unknown; empty: none
};

struct VirtualLinkage {
  int unknowns = 0;                                 ///< real numbers w
  std::vector<std::vector<VirtualHeight>> corners;  ///< per counterweight and corner; not with moments
  std::vector<PlacedHeight> placed;                 ///< per counterweight; only with moments
  std::vector<PlacedHeight> inertias;               ///< per PlanarLinkage::inertias
  VirtualHeight fixed_masses;                       ///< Σ m h over the fixed masses and inertias [kg]
  LengthPolynomial fixed_size;                      ///< of the objective, times the scale of fixed_masses [kg]
  std::vector<LengthPolynomial> positive;           ///< scales that must be positive for the lengths in question
};

struct VirtualLinkageResult {
  std::optional<VirtualLinkage> linkage;
  std::string reason;  ///< as in LinkageReading
};

/// @param box of lengths, on which all scales are positive
VirtualLinkageResult make_virtual_linkage(const PlanarLinkage& linkage, const LengthBox& box);

}  // namespace balance::certificate
