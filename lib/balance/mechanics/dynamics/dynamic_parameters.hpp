#pragma once
/// The parameters in which forces are linear: masses, first moments and moments of inertia of everything that moves,
/// and the stiffnesses of springs.

#include "balance/mechanics/model/mechanism.hpp"

#include <string>
#include <vector>

namespace balance::dynamics {

/// The kind of element that owns a parameter. Loads, friction, dampers and springs with a table are known terms
/// (synthesis/conditions/known_terms.hpp), not design parameters.
enum class ParameterOwner { body, attachment, disc, spring, load, friction, force_element };

/// What a parameter measures, which determines its physically admissible values.
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
  tabulated,           ///< largest force of a table [N] or effort [N m], not negative
  known_term,          ///< in proofs: the sum of the known terms of a condition
};

struct Parameter {
  std::string name;    ///< "link1.mx", "cw2.J", "s1.k"
  std::string owner;   ///< "link1": the owner's name, made unique by its section if two owners share it
  std::string symbol;  ///< planar m, mx, my, J; spatial m, mx, …, Ixx, …; of springs k, kax, kaxby, …, preload
  ParameterOwner owner_kind = ParameterOwner::body;
  int index = 0;  ///< into Mechanism::bodies (from 1), attachments, discs, springs, loads, friction or force_elements
  int slot = 0;   ///< position among the owner's parameters
  ParameterKind kind = ParameterKind::mass;
  int length_power = 0;  ///< of its unit: kg m^p; for springs N/m m^p, loads N m^p, friction kg m^p/s or kg m^p/s^2
};

/// SI unit of a parameter: "kg m^2", "N/m", "N m/rad".
std::string unit_of(const Parameter& parameter);

/// Per spring: whether it is loose, that is, described by all products of stiffness and end points, so that conditions
/// do not depend on the position of its ends. Possible for springs of zero free length. Other springs have one
/// parameter, the stiffness; joint springs always have two, stiffness and preload. Empty: none.
using FreeSprings = std::vector<bool>;

/// All parameters of a mechanism: bodies, attachments, discs, springs, in the mechanism's order. Bodies and
/// attachments: about the origin of the (carrying) body's frame, in its axes. Discs: about their CoM, in the carrier's
/// axes at coordinate zero, rotating with the disc.
std::vector<Parameter> list_parameters(const Mechanism& mechanism, const FreeSprings& loose = {});

/// Their values [SI], in the same order.
VectorX parameter_values(const Mechanism& mechanism, const FreeSprings& loose = {});

}  // namespace balance::dynamics
