// The faults of constraints on speeds.

#include "balance/model/fault_list.hpp"

#include <set>

namespace balance {

void check_constraints(const Mechanism& mechanism, std::vector<Fault>& all) {
  const bool planar = mechanism.space == SpaceKind::planar;
  std::set<std::string> names;
  for (std::size_t k = 0; k < mechanism.constraints.size(); ++k) {
    const Speed& constraint = mechanism.constraints[k];
    ElementFaults faults(ElementKind::constraint, k, constraint.name, all);
    if (!constraint.name.empty() && !names.insert(constraint.name).second)
      faults.add(FaultKind::duplicate_name, "another constraint has the same name");
    if (constraint.terms.empty()) faults.add(FaultKind::index_out_of_range, "what must be zero is missing");
    for (const SpeedTerm& term : constraint.terms) {
      using enum SpeedTerm::Of;
      if (faults.finite(term.factor, "a factor") && term.factor == 0)
        faults.add(FaultKind::ratio_zero, "no factor must be zero: what does not count is left out");
      if (term.of == coordinate) {
        faults.in_range(term.index, mechanism.coordinates.size(), "a coordinate");
        continue;
      }
      faults.in_range(term.body, mechanism.bodies.size(), "a body");
      faults.place(term.position, planar, "a point");
      const bool turns = term.of == turning || term.of == turning_own;
      if (faults.in_range(term.index, 3, "a component") && planar && (term.index == 2) != turns)
        faults.add(FaultKind::out_of_plane, "in the plane points move along x and y, and bodies turn about z");
    }
  }
}

}  // namespace balance
