#pragma once
/// A planar linkage as polynomials of its free lengths: a spanning tree, the closures of its loops, and the masses that
/// it carries.
///
/// Its motion is that of complex vectors z_k. Bodies that revolute joints and pins in slots connect have directions, unit
/// complex numbers; prismatic and fixed joints give bodies the same direction up to a constant factor. A slide s along a
/// direction e adds the vector s e, along the ground the real number s. Along a spanning tree from the ground, the joint
/// that carries body k is at
///
///     p_k = Σ_i R_ki z_i + constant,
///
/// where R_ki are complex numbers that depend on the lengths, and every joint that closes loop j requires
/// Σ_k L_jk z_k + constant = 0. Places on a body are measured from the joint that carries it, along the direction that
/// it shares with others.
///
/// The conjugate of a closure is a relation of the conjugate vectors, of which only the ground's slides are vectors
/// themselves. So where only slides of the ground are left in a closure, or in a combination of two, its real and its
/// imaginary part are two closures; likewise where only one direction and its slides are left, divided by the direction.

#include "balance/motion/study/design_space.hpp"
#include "balance/synthesis/certificate/bernstein_form.hpp"
#include "balance/synthesis/certificate/length_polynomial.hpp"

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace balance::certificate {

/// A function of time with complex values.
struct MovingVector {
  std::string name;       ///< of a body with this direction, or of the joint that slides
  int slides_along = -1;  ///< direction of a slide, 0: the ground's; −1: this is a direction itself
};

/// Σ_k coefficient_k z_k; absent vectors have coefficient 0, and vector 0 is 1: the ground's direction.
using VectorSum = std::map<int, LengthPolynomial>;
VectorSum operator+(VectorSum a, const VectorSum& b);
VectorSum operator*(const VectorSum& sum, const LengthPolynomial& factor);

struct LoopClosure {
  VectorSum links;          ///< L_jk
  LengthPolynomial ground;  ///< the constant: a vector of the ground
};

struct OppositeDirection {
  int other = 0;  ///< into PlanarLinkage::vectors
  LengthPolynomial::Coefficient factor = 1;
};

/// A mass whose place and value follow the lengths.
struct CarriedMass {
  int body = 0;
  LengthPolynomial place;  ///< from the body's tree joint, along the body's direction vector [m]
  LengthPolynomial mass;   ///< [kg]
};

/// An angular velocity Σ_k factor_k θ̇_k over the angles of directions, with a ratio that may be free:
/// constant + ratio · per_ratio. The sums are over vectors, of which only directions occur.
struct RatioSpin {
  VectorSum constant, per_ratio;
  int ratio_number = -1;  ///< free number that is the ratio; −1: there is none
};

/// A moment of inertia between bounds, of a body or a disc; also a given one in a free ratio.
struct FreeInertia {
  std::string name;
  double lower = 0, upper = 0;
  int number = -1;  ///< free number that it is; −1: it is given, and its value is in the spin
  int disc = -1;    ///< into Mechanism::discs; −1: it is another's
  RatioSpin spin;   ///< angular momentum per unit and angular velocity
};

/// A counterweight or disc whose mass lies between bounds, at a point of a box (or an interval, or a fixed point).
struct FreeCounterweight {
  int attachment = -1;  ///< into Mechanism::attachments; −1: it is a disc
  int disc = -1;        ///< into Mechanism::discs
  std::string name;
  int body = 0;
  std::vector<LengthPolynomial> corners;     ///< of its box, from the body's tree joint [m]
  double lower = 0, upper = 0;               ///< of its mass [kg]
  int mass_number = -1;                      ///< free number that is its mass; −1: the mass is fixed
  std::array<int, 2> place_numbers{-1, -1};  ///< free numbers that are its coordinates; −1: none
  LengthPolynomial origin;                   ///< its place where these coordinates are zero, as the corners
  RatioSpin spin;                            ///< of an inertia in proportion to the mass, per unit of mass [m²]
};

struct PlanarLinkage {
  int variables = 0;  ///< of all polynomials: the study's free numbers
  std::vector<MovingVector> vectors;
  std::vector<int> directions;                              ///< per body: into vectors
  std::vector<LengthPolynomial::Coefficient> turns;         ///< per body: its x axis, divided by its direction vector
  std::vector<VectorSum> tree_joints;                       ///< per body: R_k and the constant
  std::vector<std::vector<LengthPolynomial>> joint_places;  ///< per vector: places of its bodies' other joints
  std::vector<std::array<int, 2>> joints;                   ///< the two directions of each joint that lets them turn
  int loops = 0;                                            ///< of the mechanism
  bool has_gears = false;
  std::vector<LoopClosure> closures;  ///< at least one per loop
  /// Directions that gears turn against others: z_k = factor · conjugate of the other. Only where statics count.
  std::map<int, OppositeDirection> opposites;
  std::vector<LengthPolynomial> divisors;  ///< must not vanish, for the closures to be equivalent to the loops
  /// Of gravity, a unit complex number, if only statics are to be balanced: forces of the ground's slides count along it
  /// alone.
  std::optional<LengthPolynomial::Coefficient> gravity_direction;
  std::optional<LoopClosure> tool;  ///< position of the tool point, with the ground's constant
  std::vector<CarriedMass> masses;  ///< of bodies, payloads, and of discs and counterweights with fixed masses
  std::vector<FreeCounterweight> counterweights;
  std::vector<int> sized_places;  ///< free numbers that are coordinates of counterweights, with sizes
  LengthPolynomial fixed_size;    ///< what the objective counts besides the free counterweights [kg]
  bool balances_forces = true;    ///< or statics, by gravity_direction
  bool balances_moments = false;  ///< what follows is empty otherwise
  LengthPolynomial::Coefficient moment_reference = 0;  ///< in the ground's axes [m]
  std::vector<FreeInertia> inertias;
  VectorSum fixed_spin;  ///< Σ inertia · angular velocity of what has a given inertia [kg m²]
};

/// Free numbers that are ratios of discs on their own.
std::vector<int> list_free_ratios(const PlanarLinkage& linkage);

/// Whether closures, masses or places depend on any free number, except coordinates of counterweights that have sizes.
bool has_free_lengths(const PlanarLinkage& linkage);

struct LinkageReading {
  std::optional<PlanarLinkage> linkage;
  std::string reason;  ///< why there is none: completes "no certificate because …"
};

/// Combinations of more closures than these are not enumerated; linkages have few loops.
inline constexpr std::size_t max_combined_closures = 4;

/// Free numbers that are replaced by polynomials of the others.
using LengthSubstitution = std::map<int, LengthPolynomial>;

/// Whether the goals of a design require that shaking moments vanish.
bool requires_moment_balance(const DesignSpace& space);
/// The point that moments are about: that of the first trajectory, in the world [m].
Vector3 find_moment_reference(const DesignSpace& space);
/// Whether they require that forces or static efforts vanish.
bool requires_force_or_static_balance(const DesignSpace& space);

/// The bounds of all free numbers, in the study's order; infinite where a number has none.
LengthBox list_number_bounds(const DesignSpace& space);

/// The linkage of a design that asks for balanced forces, statics or moments and minimises the added or the total mass.
/// @param has_moments whether the conditions of moments are included, if the goals require them
LinkageReading read_linkage(const DesignSpace& space, const LengthSubstitution& substitution = {},
                            bool has_moments = false);

}  // namespace balance::certificate
