#pragma once
/// A scalar of a mechanism, identified by its location, so that derivatives can be taken with respect to it.

#include "balance/mechanics/model/mechanism.hpp"

#include <string>
#include <vector>

namespace balance::derivatives {

// Changes of a variable that over-constrained loops cannot follow: no mechanism exists in which that variable alone is
// changed, so the resulting change of a run is not a derivative.

/// Gap that opens in a joint per unit change of a variable, with the coordinates moved so that the gaps are minimal in
/// the least-squares sense.
struct ClosureGap {
  JointId joint;
  bool is_length = false;  ///< else an angle
  double gap = 0;          ///< [m] or [rad] per unit of the variable
};

/// The gaps of one variable; empty if the loops can follow it.
using ClosureGaps = std::vector<ClosureGap>;

/// Identifies a variable: `index` is an index into the list that the kind names first, `row` and `column` select a
/// component of a vector or matrix.
struct MechanismVariable {
  enum class Kind {
    gravity,                    ///< component `row` [m/s^2]
    body_mass,                  ///< [kg]
    body_com,                   ///< component `row` [m]
    body_inertia,               ///< entry (row, column) and its mirror image [kg m^2]
    joint_point_first,          ///< component `row` [m]
    joint_point_second,         ///< component `row` [m]
    attachment_mass,            ///< [kg]
    attachment_position,        ///< component `row` [m]
    attachment_inertia,         ///< as body_inertia
    disc_mass,                  ///< [kg]
    disc_position,              ///< component `row` [m]
    disc_inertia,               ///< as body_inertia
    disc_ratio,                 ///< of the disc's rate to the rate that it follows
    disc_term_ratio,            ///< of the term `column` in the combination that the disc follows
    coupling_ratio,             ///< of the follower's to the leader's rate
    coupling_term_ratio,        ///< of the term `column` in the combination that the follower follows
    coupling_offset,            ///< [rad or m]
    spring_stiffness,           ///< [N/m]
    spring_free_length,         ///< [m]
    spring_preload,             ///< of a joint spring [N m] or [N]
    spring_point_first,         ///< component `row` [m]
    spring_point_second,        ///< component `row` [m]
    friction_viscous,           ///< [N m s/rad] or [N s/m]
    friction_coulomb,           ///< [N m] or [N]; in both directions unless there is a backward value, else forwards
    friction_coulomb_backward,  ///< [N m] or [N]
    damper_damping,             ///< of an element of force_elements [N s/m]
    table_force,                ///< row `column` of the table of an element of force_elements [N] or [N m]
    element_point_first,        ///< of force_elements, component `row` [m]
    element_point_second,       ///< of force_elements, component `row` [m]
    load_force,                 ///< component `row` of the entry `column` [N]
    load_moment,                ///< component `row` of the entry `column` [N m]
    tool_position,              ///< component `row` [m]
  };
  Kind kind = Kind::body_mass;
  int index = 0;
  int row = 0, column = 0;
};

/// @throws std::invalid_argument if the mechanism has no such variable
void require_variable(const Mechanism& mechanism, const MechanismVariable& variable);

/// The variable in a mechanism over any scalar type. @pre it exists (require_variable)
template <class T>
T& variable_in(MechanismOf<T>& mechanism, const MechanismVariable& variable) {
  const auto element = [&](auto& list) -> auto& { return list[static_cast<std::size_t>(variable.index)]; };
  const auto term = [&](auto& sum) -> auto& { return sum.terms[static_cast<std::size_t>(variable.column)].ratio; };
  using enum MechanismVariable::Kind;
  switch (variable.kind) {
    case gravity: return mechanism.gravity[variable.row];
    case body_mass: return element(mechanism.bodies).mass;
    case body_com: return element(mechanism.bodies).com[variable.row];
    case body_inertia: return element(mechanism.bodies).inertia(variable.row, variable.column);
    case joint_point_first: return element(mechanism.joints).point_first[variable.row];
    case joint_point_second: return element(mechanism.joints).point_second[variable.row];
    case attachment_mass: return element(mechanism.attachments).mass;
    case attachment_position: return element(mechanism.attachments).position[variable.row];
    case attachment_inertia: return element(mechanism.attachments).inertia(variable.row, variable.column);
    case disc_mass: return element(mechanism.discs).mass;
    case disc_position: return element(mechanism.discs).position[variable.row];
    case disc_inertia: return element(mechanism.discs).inertia(variable.row, variable.column);
    case disc_ratio: return element(mechanism.discs).ratio;
    case disc_term_ratio: return term(element(mechanism.discs).follows);
    case coupling_ratio: return element(mechanism.couplings).ratio;
    case coupling_term_ratio: return term(element(mechanism.couplings).leader);
    case coupling_offset: return element(mechanism.couplings).offset;
    case spring_stiffness: return element(mechanism.springs).stiffness;
    case spring_free_length: return element(mechanism.springs).free_length;
    case spring_preload: return element(mechanism.springs).preload;
    case spring_point_first: return element(mechanism.springs).point_first[variable.row];
    case spring_point_second: return element(mechanism.springs).point_second[variable.row];
    case friction_viscous: return element(mechanism.friction).viscous;
    case friction_coulomb: return element(mechanism.friction).coulomb;
    case friction_coulomb_backward: return *element(mechanism.friction).coulomb_backward;
    case damper_damping: return element(mechanism.force_elements).damping;
    case table_force: return element(mechanism.force_elements).table.force[static_cast<std::size_t>(variable.column)];
    case element_point_first: return element(mechanism.force_elements).point_first[variable.row];
    case element_point_second: return element(mechanism.force_elements).point_second[variable.row];
    case load_force: return element(mechanism.loads).force[static_cast<std::size_t>(variable.column)][variable.row];
    case load_moment: return element(mechanism.loads).moment[static_cast<std::size_t>(variable.column)][variable.row];
    case tool_position: return mechanism.tool->position[variable.row];
  }
  return mechanism.gravity[0];
}

/// Whether the variable is an off-diagonal entry of a symmetric matrix, which has a mirror image.
bool has_symmetric_entry(const MechanismVariable& variable);

}  // namespace balance::derivatives

namespace balance {

using derivatives::MechanismVariable;

}  // namespace balance
