#pragma once
/// A lower bound on the least added mass over all lengths of a box, by one linear program.
///
/// Multipliers w(l), constant or affine in some lengths, are a certificate if every inequality of the virtual linkage
/// holds on the whole box, which the signs of its Bernstein coefficients prove. A counterweight with mass limits has
/// one more multiplier σ(l), with σ ≤ lower (1 − h) and σ ≤ upper (1 − h) at every corner, and adds σ to the bound. One
/// that is left out has neither.
/// With moments, the height of a counterweight is quadratic in its place. It must hold at all places, but rows at few of
/// them are enough: the highest places of a solution are added until none is higher than allowed. A moment of inertia
/// costs nothing: it has a σ with σ ≤ −lower h and σ ≤ −upper h in both ends of its ratio.
/// Conditions g(l) ≥ 0 on the lengths take part with a multiplier κ ≥ 0 (of any sign for g = 0): the objective minus κ g
/// need only be positive on the whole box. Whatever a solver returns is made a certificate: σ is shifted and all multipliers are scaled until the inequalities
/// hold (w = 0 meets all but those of σ strictly), and the bound is the smallest quotient of Bernstein coefficients of
/// the objective. A solver's tolerance costs tightness, never truth.

#include "balance/synthesis/certificate/assembly_conditions.hpp"
#include "balance/synthesis/certificate/virtual_linkage.hpp"

#include <map>

namespace balance::certificate {

/// Bound on the multipliers, so that a program is bounded where no masses balance the linkage.
inline constexpr double max_multiplier = 1e5;

/// Limits of a counterweight's mass in a part of all designs. A mass of at most 0: it is left out.
struct MassLimits {
  double lower = 0, upper = 0;  ///< [kg]
  bool is_upper_used = false;   ///< whether a bound uses the upper limit, which need not hold otherwise

  bool is_left_out() const { return upper <= 0; }
};
/// The linkage's own, upper limits not used.
std::vector<MassLimits> list_mass_limits(const PlanarLinkage& linkage);

/// Affine multipliers for the proof that no lengths of a box allow less than `bound`.
struct BoxCertificate {
  std::vector<int> affine;              ///< lengths in which the multipliers are affine
  std::vector<MassLimits> mass_limits;  ///< per counterweight
  std::vector<int> limit_index;         ///< per counterweight: its σ; −1: none. Those of inertias follow
  /// Columns: w, then σ. Rows: constant part, then the coefficients of 2t − 1 of each affine length, where t is its
  /// box coordinate.
  MatrixX multipliers;
  int unknowns = 0;               ///< number of columns of w
  std::vector<int> conditions;    ///< those of the program that take part
  VectorX condition_multipliers;  ///< κ of each
};

struct BoxBound {
  double bound = -no_length_bound;  ///< no lengths of the box allow less [kg]
  BoxCertificate certificate;
  /// Per counterweight and corner: of the relaxation; at a point, of the optimum. With moments they are at `places`.
  std::vector<VectorX> corner_masses;
  std::vector<std::vector<Vector3>> places;  ///< x, y and ratio, where free; only with moments
  std::vector<double> inertias;              ///< per PlanarLinkage::inertias, of the relaxation
  std::vector<double> ratios;                ///< of these
  MatrixX conflict;  ///< lengths × 2: how much the active inequalities want each length small, large

  static constexpr double no_length_bound = 1e300;
  double mass(std::size_t counterweight) const { return corner_masses[counterweight].sum(); }
};

/// Bernstein coefficients of the largest polynomial with moments.
Eigen::Index count_coefficients(const VirtualLinkage& dual, const std::vector<LengthCondition>& conditions);

struct PlacedRows;

class BoxProgram {
 public:
  /// @param conditions that all lengths of interest meet
  BoxProgram(const PlanarLinkage& linkage, const VirtualLinkage& dual, std::vector<LengthCondition> conditions);

  /// Lengths on which the bound depends.
  const std::vector<int>& lengths() const { return lengths_; }
  /// Coordinates of counterweights within the box on which the bound depends.
  const std::vector<int>& places() const { return places_; }
  /// All places and ratios of a box, at given lengths.
  LengthBox point_box(const VectorX& lengths, const LengthBox& box) const;
  const std::vector<LengthCondition>& conditions() const { return conditions_; }
  /// Coordinates and ratios of the counterweights' centres in the relaxation, with moments; of those without mass none.
  std::map<int, double> list_centres(const BoxBound& bound) const;
  /// Indices of the conditions that some lengths of the box break.
  std::vector<int> find_active_conditions(const LengthBox& box) const;
  /// Whether all scales are positive on the box; otherwise there is no bound.
  bool has_positive_scales(const LengthBox& box) const;
  /// @param affine lengths in which the multipliers are affine
  /// @param limits per counterweight; upper limits that the relaxation exceeds are used as well
  BoxBound bound(const LengthBox& box, const std::vector<int>& affine, std::vector<MassLimits>& limits) const;

 private:
  struct Assembly;

  BoxBound solve(const LengthBox& box, const std::vector<int>& affine, const std::vector<MassLimits>& limits) const;
  std::vector<PlacedRows> list_placed_rows(const LengthBox& box, const std::vector<int>& affine) const;

  const PlanarLinkage& linkage_;
  const VirtualLinkage& dual_;
  std::vector<int> lengths_;
  std::vector<std::vector<BernsteinForm>> corners_;  ///< scale, then coefficients
  std::vector<BernsteinForm> placed_, inertias_;     ///< scale, then coefficients of each function
  std::vector<int> places_;
  std::vector<LengthCondition> conditions_;
  BernsteinForm objective_;  ///< fixed size, scale, coefficients, then conditions
  std::vector<BernsteinForm> positive_;
};

}  // namespace balance::certificate
