#include "balance/present/conditions_view.hpp"

#include "balance/conditions/definition.hpp"
#include "balance/design/solve.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

bool ConditionsView::is_met(int row) const { return std::abs(residuals[row]) <= met; }

namespace {

std::string unit_of(const Parameter& term) {
  switch (term.kind) {
    case ParameterKind::force: return "N";
    case ParameterKind::viscous: return term.length_power == 0 ? "N s/m" : "N m s/rad";
    case ParameterKind::coulomb: return term.length_power == 1 ? "N" : "N m";
    default: return "N m";
  }
}

/// Known terms of the conditions that hold parameters, too.
std::vector<Symbol> known_values_of(const Conditions& conditions, const VectorX& values) {
  std::vector<Symbol> known;
  for (Eigen::Index column = conditions.own_columns(); column < values.size(); ++column) {
    const Parameter& term = conditions.parameters[static_cast<std::size_t>(column)];
    if (!conditions.matrix.col(column).head(conditions.own_rows()).isZero(0))
      known.push_back({term.name, unit_of(term), values[column], {}});
  }
  return known;
}

}  // namespace

void judge(ConditionsView& view, const Mechanism& mechanism, const std::vector<Trajectory>& trajectories,
           const ConditionOptions& options) {
  const VectorX values = term_values(mechanism, options.loose_springs);
  view.conditions.known = values.tail(view.conditions.known.size());
  view.residuals = scaled_residuals(view.conditions, values);
  view.known = known_values_of(view.conditions, values);
  view.staying = list_staying(mechanism, trajectories, view.conditions, options);
  // what a free number may change is left to the design
  std::erase_if(view.staying, [&](const Staying& staying) {
    const auto& rows = staying.remainder.rows;
    return std::any_of(rows.begin(), rows.end(),
                       [&](int row) { return !view.occurring[static_cast<std::size_t>(row)].empty(); });
  });
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
