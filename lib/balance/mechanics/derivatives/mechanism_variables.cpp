#include "balance/mechanics/derivatives/mechanism_variables.hpp"

#include <stdexcept>

namespace balance::derivatives {

namespace {

using Kind = MechanismVariable::Kind;

/// Number of entries of the list that `index` points into.
std::size_t count_elements(const Mechanism& mechanism, Kind kind) {
  using enum MechanismVariable::Kind;
  switch (kind) {
    case gravity: return 1;
    case tool_position: return mechanism.tool ? 1 : 0;
    case body_mass:
    case body_com:
    case body_inertia: return mechanism.bodies.size();
    case joint_point_first:
    case joint_point_second: return mechanism.joints.size();
    case attachment_mass:
    case attachment_position:
    case attachment_inertia: return mechanism.attachments.size();
    case disc_mass:
    case disc_position:
    case disc_inertia:
    case disc_ratio:
    case disc_term_ratio: return mechanism.discs.size();
    case coupling_ratio:
    case coupling_term_ratio:
    case coupling_offset: return mechanism.couplings.size();
    case spring_stiffness:
    case spring_free_length:
    case spring_preload:
    case spring_point_first:
    case spring_point_second: return mechanism.springs.size();
    case friction_viscous:
    case friction_coulomb:
    case friction_coulomb_backward: return mechanism.friction.size();
    case damper_damping:
    case table_force:
    case element_point_first:
    case element_point_second: return mechanism.force_elements.size();
    case load_force:
    case load_moment: return mechanism.loads.size();
  }
  return 0;
}

bool is_matrix(Kind kind) {
  return kind == Kind::body_inertia || kind == Kind::attachment_inertia || kind == Kind::disc_inertia;
}

/// Number of valid values of `column`.
std::size_t count_variable_columns(const Mechanism& mechanism, const MechanismVariable& variable) {
  const auto index = static_cast<std::size_t>(variable.index);
  switch (variable.kind) {
    case Kind::load_force:
    case Kind::load_moment: return mechanism.loads[index].force.size();
    case Kind::table_force: return mechanism.force_elements[index].table.force.size();
    case Kind::disc_term_ratio: return mechanism.discs[index].follows.terms.size();
    case Kind::coupling_term_ratio: return mechanism.couplings[index].leader.terms.size();
    default: return is_matrix(variable.kind) ? 3 : 1;
  }
}

}  // namespace

bool has_symmetric_entry(const MechanismVariable& variable) {
  return is_matrix(variable.kind) && variable.row != variable.column;
}

void require_variable(const Mechanism& mechanism, const MechanismVariable& variable) {
  const auto is_in_range = [](int value, std::size_t count) {
    return value >= 0 && static_cast<std::size_t>(value) < count;
  };
  const auto throw_missing = [](const std::string& what, int value) {
    throw std::invalid_argument("mechanism variable: there is no " + what + " " + std::to_string(value));
  };
  if (!is_in_range(variable.index, count_elements(mechanism, variable.kind))) throw_missing("element", variable.index);
  if (variable.kind == Kind::friction_coulomb_backward &&
      !mechanism.friction[static_cast<std::size_t>(variable.index)].coulomb_backward)
    throw std::invalid_argument("mechanism variable: that friction is the same in both directions");
  if (!is_in_range(variable.row, 3)) throw_missing("row", variable.row);
  if (!is_in_range(variable.column, count_variable_columns(mechanism, variable)))
    throw_missing("column", variable.column);
}

}  // namespace balance::derivatives
