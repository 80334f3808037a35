#include "balance/interface/reports/balance_request.hpp"

#include "balance/motion/simulation/end_configurations.hpp"
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

DeriveConditions make_perturbed_deriver(const DeriveConditions& derive, bool modular, const ConditionOptions& options,
                                        const std::vector<CoordinateValue>& start, const Mechanism& mechanism,
                                        const Conditions& conditions) {
  if (modular) return derive;
  return make_perturbed_derivation(
      derive, [start](const Mechanism& unassembled) { return simulation::assembled_at(unassembled, start); }, mechanism,
      conditions, options);
}

}  // namespace balance::reports
