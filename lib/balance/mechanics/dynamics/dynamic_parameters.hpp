#pragma once
/// The numbers that forces are linear in: masses, first moments and moments of inertia of everything that moves, and the
/// stiffnesses of springs.

#include "balance/mechanics/model/mechanism.hpp"

#include <string>
#include <vector>

namespace balance {

/// Whose parameter it is. Loads and friction are known terms (synthesis/conditions/known_terms.hpp), no parameters of a design.
enum class ParameterOwner { body, attachment, disc, spring, load, friction };

/// What it measures; what else a physical body allows hangs on it.
enum class ParameterKind {
  mass,                ///< [kg], positive
  first_moment,        ///< mass times a coordinate of the CoM [kg m]
  moment_of_inertia,   ///< about an axis through the frame's origin [kg m^2], positive
  product_of_inertia,  ///< −∫xy dm [kg m^2]
  stiffness,           ///< [N/m], in an angle [N m/rad], not negative
  stiffness_moment,    ///< stiffness times coordinates of its end points, or a preload [N] or [N m]
  force,               ///< component of a load [N], of any sign
  couple,              ///< component of a load's moment [N m], of any sign
  viscous,             ///< friction per rate [N m s] or [N s/m], not negative
  coulomb,             ///< dry friction [N m] or [N], not negative
  known_term,          ///< in proofs: what the known terms of a condition come to
};

struct Parameter {
  std::string name;    ///< "link1.mx", "cw2.J", "s1.k"
  std::string owner;   ///< "link1": the bearer's name, made unique by its section if two bearers share it
  std::string symbol;  ///< planar m, mx, my, J; spatial m, mx, …, Ixx, …; of springs k, kax, kaxby, …, preload
  ParameterOwner owner_kind = ParameterOwner::body;
  int index = 0;  ///< into Mechanism::bodies (from 1), attachments, discs, springs, loads or friction
  int slot = 0;   ///< position among the bearer's parameters
  ParameterKind kind = ParameterKind::mass;
  int length_power = 0;  ///< of its unit: kg m^p; for springs N/m m^p, loads N m^p, friction kg m^p/s or kg m^p/s^2
};

/// Which springs are described by all products of stiffness and end points, so that conditions do not depend on where their
/// ends are: possible for springs of zero free length. Others have one parameter, the stiffness; those in joint coordinates
/// always two, stiffness and preload. Empty: none.
using FreeSprings = std::vector<bool>;

/// All parameters of a mechanism: bodies, attachments, discs, springs, in the mechanism's order. Bodies and attachments: about
/// the origin of the (carrying) body's frame, in its axes; discs: about their CoM, in the carrier's axes at coordinate
/// zero, turning with the disc.
std::vector<Parameter> list_parameters(const Mechanism& mechanism, const FreeSprings& loose = {});

/// Their values [SI], in the same order.
VectorX parameter_values(const Mechanism& mechanism, const FreeSprings& loose = {});

}  // namespace balance
