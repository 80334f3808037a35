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

#include "balance/synthesis/certificate/bernstein_form.hpp"
#include "balance/synthesis/certificate/loop_closures.hpp"

namespace balance::certificate {

/// scale · h = Σ_j coefficients[j] w_j.
struct VirtualHeight {
  LengthPolynomial scale;
  std::vector<LengthPolynomial> coefficients;  ///< real, one per unknown
};

struct VirtualLinkage {
  int unknowns = 0;                                 ///< real numbers w
  std::vector<std::vector<VirtualHeight>> corners;  ///< per counterweight and corner
  VirtualHeight fixed_masses;                       ///< Σ m h over the fixed masses [kg]
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
