// The faults of constraints on speeds.

#include "balance/model/fault_list.hpp"

#include <set>

namespace balance {

void check_constraints(const Mechanism& mechanism, std::vector<ValidationIssue>& all) {
  const bool planar = mechanism.space == SpaceKind::planar;
  std::set<std::string> names;
  for (std::size_t k = 0; k < mechanism.constraints.size(); ++k) {
    const GeneralisedSpeed& constraint = mechanism.constraints[k];
    ElementValidator faults(ElementKind::constraint, k, constraint.name, all);
    if (!constraint.name.empty() && !names.insert(constraint.name).second)
      faults.add(ValidationIssueKind::duplicate_name, "another constraint has the same name");
    if (constraint.terms.empty()) faults.add(ValidationIssueKind::index_out_of_range, "what must be zero is missing");
    for (const GeneralisedSpeedTerm& term : constraint.terms) {
      using enum GeneralisedSpeedTerm::Kind;
      if (faults.check_finite(term.factor, "a factor") && term.factor == 0)
        faults.add(ValidationIssueKind::ratio_zero, "no factor must be zero: what does not count is left out");
      if (term.kind == coordinate) {
        faults.check_index(term.index, mechanism.coordinates.size(), "a coordinate");
        continue;
      }
      faults.check_index(term.body, mechanism.bodies.size(), "a body");
      faults.check_position(term.position, planar, "a point");
      const bool turns = term.kind == angular_velocity || term.kind == angular_velocity_body;
      if (faults.check_index(term.index, 3, "a component") && planar && (term.index == 2) != turns)
        faults.add(ValidationIssueKind::out_of_plane,
                   "in the plane points move along x and y, and bodies turn about z");
    }
  }
}

}  // namespace balance
