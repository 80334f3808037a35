#pragma once
/// Where geometric numbers stand in a mechanism over any scalar. Private to conditions.

#include "balance/conditions/geometry.hpp"

namespace balance {

/// The number's own place, writable if the mechanism is.
template <class AMechanism>
auto& geometric_value_at(AMechanism& m, const GeometricParameterLocation& p) {
  using Kind = GeometricParameterLocation::Kind;
  const auto at = [](int index) { return static_cast<std::size_t>(index); };
  switch (p.kind) {
    case Kind::joint_first: return m.joints[at(p.index)].point_first[p.axis];
    case Kind::joint_second: return m.joints[at(p.index)].point_second[p.axis];
    case Kind::joint_radius: return m.joints[at(p.index)].radius;
    case Kind::constraint_factor: return m.constraints[at(p.index)].terms[at(p.item)].factor;
    case Kind::constraint_point: return m.constraints[at(p.index)].terms[at(p.item)].position[p.axis];
    case Kind::body_point: return m.bodies[at(p.index)].points[at(p.item)].position[p.axis];
    case Kind::tool: return m.tool.value().position[p.axis];
    case Kind::disc: return m.discs[at(p.index)].position[p.axis];
    case Kind::disc_ratio: return m.discs[at(p.index)].ratio;
    case Kind::disc_term_ratio: return m.discs[at(p.index)].follows.terms[at(p.item)].ratio;
    case Kind::coupling_term_ratio: return m.couplings[at(p.index)].leader.terms[at(p.item)].ratio;
    case Kind::coupling_ratio: return m.couplings[at(p.index)].ratio;
    case Kind::spring_first: return m.springs[at(p.index)].point_first[p.axis];
    case Kind::spring_second: return m.springs[at(p.index)].point_second[p.axis];
    case Kind::load: return m.loads[at(p.index)].point[p.axis];
    case Kind::free_length: return m.springs[at(p.index)].free_length;
    case Kind::gravity: break;
  }
  return m.gravity[p.axis];
}

}  // namespace balance
