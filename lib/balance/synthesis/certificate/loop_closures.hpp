#pragma once
/// A planar linkage of revolute joints as polynomials of its free lengths: a spanning tree, the closures of its loops,
/// and the masses that it carries.
///
/// Body k has the unit complex number e_k as its direction. Along a spanning tree from the ground, the joint that
/// carries body k is at
///
///     p_k = Σ_i R_ki e_i + constant,
///
/// where R_ki are complex numbers that depend on the lengths, and every joint that closes loop j requires
/// Σ_k L_jk e_k + constant = 0. Places on a body are measured from the joint that carries it.

#include "balance/motion/study/design_space.hpp"
#include "balance/synthesis/certificate/length_polynomial.hpp"

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace balance::certificate {

/// Σ_k coefficient_k e_k; absent bodies have coefficient 0.
using BodySum = std::map<int, LengthPolynomial>;
BodySum operator+(BodySum a, const BodySum& b);
BodySum operator*(const BodySum& sum, const LengthPolynomial& factor);

struct LoopClosure {
  BodySum links;            ///< L_jk
  LengthPolynomial ground;  ///< the constant: a vector of the ground
};

/// A mass whose place and value follow the lengths.
struct CarriedMass {
  int body = 0;
  LengthPolynomial place;  ///< from the body's tree joint, body axes [m]
  LengthPolynomial mass;   ///< [kg]
};

/// A counterweight whose mass lies between bounds, at a point of a box (or an interval, or a fixed point).
struct FreeCounterweight {
  int attachment = 0;  ///< into Mechanism::attachments
  std::string name;
  int body = 0;
  std::vector<LengthPolynomial> corners;     ///< of its box, from the body's tree joint [m]
  double lower = 0, upper = 0;               ///< of its mass [kg]
  int mass_number = -1;                      ///< free number that is its mass; −1: the mass is fixed
  std::array<int, 2> place_numbers{-1, -1};  ///< free numbers that are its coordinates; −1: none
};

struct PlanarLinkage {
  int variables = 0;  ///< of all polynomials: the study's free numbers
  std::vector<std::string> body_names;
  std::vector<BodySum> tree_joints;                         ///< per body: R_k
  std::vector<std::vector<LengthPolynomial>> joint_places;  ///< per body: places of its other joints
  std::vector<std::array<int, 2>> joints;                   ///< the two bodies of each
  std::vector<LoopClosure> closures;
  std::optional<LoopClosure> tool;  ///< position of the tool point, with the ground's constant
  std::vector<CarriedMass> masses;  ///< of bodies, payloads and fixed counterweights
  std::vector<FreeCounterweight> counterweights;
  std::vector<int> sized_places;  ///< free numbers that are coordinates of counterweights, with sizes
  LengthPolynomial fixed_size;    ///< what the objective counts besides the free counterweights [kg]
};

/// Whether closures, masses or places depend on any free number, sizes of counterweights' coordinates apart.
bool has_free_lengths(const PlanarLinkage& linkage);

struct LinkageReading {
  std::optional<PlanarLinkage> linkage;
  std::string reason;  ///< why there is none: completes "no certificate because …"
};

/// Combinations of more closures than these are not enumerated; linkages have few loops.
inline constexpr std::size_t max_combined_closures = 4;

/// Free numbers that are replaced by polynomials of the others.
using LengthSubstitution = std::map<int, LengthPolynomial>;

/// The linkage of a design that asks for balanced forces or statics and minimises the added or the total mass.
LinkageReading read_linkage(const DesignSpace& space, const LengthSubstitution& substitution = {});

}  // namespace balance::certificate
