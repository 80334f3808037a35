#include "balance/interface/reports/balance_request.hpp"

#include "balance/mechanics/model/mechanism.hpp"
#include "balance/motion/simulation/end_configurations.hpp"
#include "balance/synthesis/conditions/graph_partition.hpp"
#include "balance/synthesis/conditions/modular_conditions.hpp"
#include "balance/synthesis/conditions/perturbed_conditions.hpp"

namespace balance::reports {

DeriveConditions make_conditions_deriver(const std::vector<Goal>& goals, bool modular, const ConditionOptions& options,
                                         const std::vector<CoordinateValue>& start) {
  return [=](const Mechanism& unassembled) {
    const Mechanism mechanism = simulation::assembled_at(unassembled, start);
    return modular ? derive_modular_conditions(mechanism, goals, options)
                   : derive_conditions(mechanism, goals, options);
  };
}

namespace {

/// Moves payloads and the tool along with the joint at which they are: chains are told apart, and loads shared between
/// them, by places that coincide.
Mechanism keep_coincident_places(const Mechanism& given, Mechanism changed) {
  const double tolerance = conditions::coincidence_tolerance * characteristic_length(given);
  const auto carry = [&](BodyId body, const Vector3& place, Vector3& moved) {
    for (std::size_t j = 0; j < given.joints.size(); ++j)
      for (const bool first : {true, false}) {
        const Joint &before = given.joints[j], &after = changed.joints[j];
        if (body != (first ? before.first : before.second)) continue;
        if ((place - (first ? before.point_first : before.point_second)).norm() > tolerance) continue;
        moved = first ? after.point_first : after.point_second;
        return;
      }
  };
  for (std::size_t a = 0; a < given.attachments.size(); ++a)
    if (given.attachments[a].kind == AttachmentKind::payload)
      carry(given.attachments[a].body, given.attachments[a].position, changed.attachments[a].position);
  if (given.tool) carry(given.tool->body, given.tool->position, changed.tool->position);
  return changed;
}

}  // namespace

DeriveConditions make_perturbed_deriver(const DeriveConditions& derive, bool modular, const ConditionOptions& options,
                                        const std::vector<CoordinateValue>& start, const Mechanism& mechanism,
                                        const Conditions& conditions) {
  if (modular) return [=](const Mechanism& changed) { return derive(keep_coincident_places(mechanism, changed)); };
  return make_perturbed_derivation(
      derive, [start](const Mechanism& unassembled) { return simulation::assembled_at(unassembled, start); }, mechanism,
      conditions, options);
}

}  // namespace balance::reports
