#pragma once
/// The numbers of a mechanism that measurements are to find, in which its equation of motion is linear.

#include "balance/mechanics/dynamics/dynamic_parameters.hpp"
#include "balance/mechanics/model/mechanism.hpp"

#include <string>
#include <vector>

namespace balance::identification {

enum class UnknownKind {
  body,          ///< inertial parameter of a body, about the body's origin, as in dynamics::list_parameters
  payload,       ///< inertial parameter of a payload that is to be found
  disc_inertia,  ///< moment of inertia of a disc about its axis: of the rotor of a drive
  viscous,       ///< friction per rate
  coulomb,       ///< dry friction, mean of both directions
  offset,        ///< constant effort against the motion forwards, such as half of the difference of both directions
};

inline bool is_friction(UnknownKind kind) { return kind >= UnknownKind::viscous; }

struct UnknownParameter {
  std::string name;   ///< "link1.mx", "A1.viscous", "rotor4.J"
  std::string owner;  ///< "link1", "A1"
  std::string unit;   ///< SI
  UnknownKind kind = UnknownKind::body;
  int element = 0;        ///< index of the body, attachment, disc or coordinate
  int slot = 0;           ///< of an inertial parameter: position among its owner's
  double spec_value = 0;  ///< [SI]
};

/// Which parts of friction are to be found in the coordinates that have no friction in the spec.
enum class PassiveFriction { none, viscous, dry };

struct UnknownOptions {
  PassiveFriction passive_friction = PassiveFriction::viscous;
  std::vector<std::string> payloads;  ///< payloads whose inertial parameters are unknown
};

/// All unknowns: of every body with mass; of every disc its moment of inertia about its axis; of friction, in this
/// order: viscous, Coulomb, offset of actuated coordinates, viscous and Coulomb of others with friction in the spec (viscous alone if only that is not zero), and
/// what the options say of the remaining ones. Coordinates of spherical, planar, free and rolling joints have friction
/// only if the spec says so.
std::vector<UnknownParameter> list_unknowns(const Mechanism& mechanism, const UnknownOptions& options);

/// Groups in the order in which find_base_combinations() chooses columns: names that people know come first. Payloads,
/// friction, drives, moments of bodies, and last their masses, which few motions show by themselves.
int column_group(const UnknownParameter& unknown);

/// The mechanism with friction entries wherever friction is unknown, so that its coordinates are not cut.
Mechanism with_friction_coordinates(const Mechanism& mechanism, const std::vector<UnknownParameter>& unknowns);

/// The mechanism with these values in place of its own. An offset becomes a spring of zero stiffness in the joint, as in
/// the spec language.
/// @param values per unknown [SI]
Mechanism apply_values(const Mechanism& mechanism, const std::vector<UnknownParameter>& unknowns,
                       const VectorX& values);

/// Values of all inertial parameters of MotionEquation::inertial that are not unknown; unknown ones are zero.
/// @param carried names of the payloads that are carried; others count as massless
VectorX known_inertial_values(const Mechanism& mechanism, const VectorX& all_values,
                              const std::vector<UnknownParameter>& unknowns, const std::vector<std::string>& carried);

/// Number of inertial parameters of one element: 4 in the plane, 10 in space.
inline int inertial_parameter_count(const Mechanism& mechanism) {
  return mechanism.space == SpaceKind::planar ? 4 : 10;
}

/// Index of an element's first inertial parameter.
int first_inertial_parameter(const Mechanism& mechanism, dynamics::ParameterOwner owner, int element);

/// Factors of a disc's inertial parameters per unit moment of inertia about its axis.
VectorX axial_inertia_factors(const Mechanism& mechanism, const Disc& disc);

}  // namespace balance::identification
