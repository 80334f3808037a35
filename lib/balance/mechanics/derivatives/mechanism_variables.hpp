#pragma once
/// A number of a mechanism, named by where it stands, so that derivatives can be taken with respect to it.

#include "balance/mechanics/model/mechanism.hpp"

#include <string>
#include <vector>

namespace balance {

// Changes of a number that over-constrained loops cannot follow: no mechanism has the number changed by itself, and what its change
// does to a run is no derivative.

/// What a joint opens by per unit of a number while all others are held together, coordinates being moved so that it is least.
struct ClosureGap {
  JointId joint;
  bool is_length = false;  ///< else an angle
  double gap = 0;          ///< [m] or [rad] per unit of the number
};

/// Of one number; empty if the loops follow it.
using ClosureGaps = std::vector<ClosureGap>;

/// Which number; `index` counts the list that is named first, `row` and `column` the components of a vector or matrix.
struct MechanismVariable {
  enum class Kind {
    gravity,              ///< component `row` [m/s^2]
    body_mass,            ///< [kg]
    body_com,             ///< component `row` [m]
    body_inertia,         ///< entry (row, column) and its mirror image [kg m^2]
    joint_point_first,    ///< component `row` [m]
    joint_point_second,   ///< component `row` [m]
    attachment_mass,      ///< [kg]
    attachment_position,  ///< component `row` [m]
    attachment_inertia,   ///< as body_inertia
    disc_mass,            ///< [kg]
    disc_position,        ///< component `row` [m]
    disc_inertia,         ///< as body_inertia
    disc_ratio,           ///< of the disc's rate to that of what it follows
    disc_term_ratio,      ///< of the coordinate `column` in what the disc follows
    coupling_ratio,       ///< of the follower's to the leader's rate
    coupling_term_ratio,  ///< of the coordinate `column` in what the follower follows
    coupling_offset,      ///< [rad or m]
    spring_stiffness,     ///< [N/m]
    spring_free_length,   ///< [m]
    spring_preload,       ///< of one in a joint [N m] or [N]
    spring_point_first,   ///< component `row` [m]
    spring_point_second,  ///< component `row` [m]
    friction_viscous,     ///< [N m s/rad] or [N s/m]
    friction_coulomb,     ///< [N m] or [N]; in both directions where the mechanism tells none apart, else forwards
    friction_coulomb_backward,  ///< [N m] or [N]
    load_force,                 ///< component `row` of the entry `column` [N]
    load_moment,                ///< component `row` of the entry `column` [N m]
    tool_position,              ///< component `row` [m]
  };
  Kind kind = Kind::body_mass;
  int index = 0;
  int row = 0, column = 0;
};

/// @throws std::invalid_argument if the mechanism has no such number
void require_variable(const Mechanism& mechanism, const MechanismVariable& number);

/// The number in a mechanism over any scalar; it must exist.
template <class T>
T& variable_in(MechanismOf<T>& mechanism, const MechanismVariable& number) {
  const auto at = [&](auto& list) -> auto& { return list[static_cast<std::size_t>(number.index)]; };
  const auto term = [&](auto& sum) -> auto& { return sum.terms[static_cast<std::size_t>(number.column)].ratio; };
  using enum MechanismVariable::Kind;
  switch (number.kind) {
    case gravity: return mechanism.gravity[number.row];
    case body_mass: return at(mechanism.bodies).mass;
    case body_com: return at(mechanism.bodies).com[number.row];
    case body_inertia: return at(mechanism.bodies).inertia(number.row, number.column);
    case joint_point_first: return at(mechanism.joints).point_first[number.row];
    case joint_point_second: return at(mechanism.joints).point_second[number.row];
    case attachment_mass: return at(mechanism.attachments).mass;
    case attachment_position: return at(mechanism.attachments).position[number.row];
    case attachment_inertia: return at(mechanism.attachments).inertia(number.row, number.column);
    case disc_mass: return at(mechanism.discs).mass;
    case disc_position: return at(mechanism.discs).position[number.row];
    case disc_inertia: return at(mechanism.discs).inertia(number.row, number.column);
    case disc_ratio: return at(mechanism.discs).ratio;
    case disc_term_ratio: return term(at(mechanism.discs).follows);
    case coupling_ratio: return at(mechanism.couplings).ratio;
    case coupling_term_ratio: return term(at(mechanism.couplings).leader);
    case coupling_offset: return at(mechanism.couplings).offset;
    case spring_stiffness: return at(mechanism.springs).stiffness;
    case spring_free_length: return at(mechanism.springs).free_length;
    case spring_preload: return at(mechanism.springs).preload;
    case spring_point_first: return at(mechanism.springs).point_first[number.row];
    case spring_point_second: return at(mechanism.springs).point_second[number.row];
    case friction_viscous: return at(mechanism.friction).viscous;
    case friction_coulomb: return at(mechanism.friction).coulomb;
    case friction_coulomb_backward: return *at(mechanism.friction).coulomb_backward;
    case load_force: return at(mechanism.loads).force[static_cast<std::size_t>(number.column)][number.row];
    case load_moment: return at(mechanism.loads).moment[static_cast<std::size_t>(number.column)][number.row];
    case tool_position: return mechanism.tool->position[number.row];
  }
  return mechanism.gravity[0];
}

/// Whether it is an entry of a symmetric matrix off its diagonal, which has a mirror image.
bool has_symmetric_entry(const MechanismVariable& number);

}  // namespace balance
