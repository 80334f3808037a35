#include "balance/write/conditions_view.hpp"

#include "balance/conditions/definition.hpp"
#include "balance/design/solve.hpp"

#include <cmath>

namespace balance {

bool ConditionsView::is_met(int row) const { return std::abs(residuals[row]) <= met; }

void judge(ConditionsView& view, const Mechanism& mechanism, const LooseSprings& loose) {
  view.residuals = scaled_residuals(view.conditions, parameter_values(mechanism, loose));
  view.by_definition.clear();
  for (int row = 0; row < view.residuals.size(); ++row)
    view.by_definition.push_back(view.is_met(row) && holds_for_any_disc(view.conditions, row, mechanism));
}

LooseSprings loose_springs_of(const Conditions& conditions, const Mechanism& mechanism) {
  LooseSprings loose(mechanism.springs.size(), false);
  for (const Parameter& p : conditions.parameters)
    if (p.bearer == Bearer::spring && p.slot > 0) loose[static_cast<std::size_t>(p.index)] = true;
  return loose;
}

}  // namespace balance
