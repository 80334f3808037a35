#include "balance/present/conditions_view.hpp"

#include "balance/conditions/definition.hpp"
#include "balance/design/solve.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

bool ConditionsReportData::is_met(int row) const { return std::abs(residuals[row]) <= condition_tolerance; }

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
std::vector<GeometricSymbol> known_values_of(const Conditions& conditions, const VectorX& values) {
  std::vector<GeometricSymbol> known;
  for (Eigen::Index column = conditions.parameter_columns(); column < values.size(); ++column) {
    const Parameter& term = conditions.parameters[static_cast<std::size_t>(column)];
    if (!conditions.matrix.col(column).head(conditions.parameter_rows()).isZero(0))
      known.push_back({term.name, unit_of(term), values[column], {}});
  }
  return known;
}

}  // namespace

void evaluate_conditions(ConditionsReportData& view, const Mechanism& mechanism,
                         const std::vector<Trajectory>& trajectories, const ConditionOptions& options) {
  const VectorX values = term_values(mechanism, options.loose_springs);
  view.conditions.known_term_values = values.tail(view.conditions.known_term_values.size());
  view.residuals = scaled_residuals(view.conditions, values);
  view.known_terms = known_values_of(view.conditions, values);
  view.unbalanced_remainder = list_unbalanced_remainders(mechanism, trajectories, view.conditions, options);
  // what a free number may change is left to the design
  std::erase_if(view.unbalanced_remainder, [&](const UnbalancedRemainder& staying) {
    const auto& rows = staying.element.rows;
    return std::any_of(rows.begin(), rows.end(),
                       [&](int row) { return !view.free_number_indices[static_cast<std::size_t>(row)].empty(); });
  });
  view.holds_by_definition.clear();
  for (int row = 0; row < view.residuals.size(); ++row)
    view.holds_by_definition.push_back(view.is_met(row) && is_met_by_symmetric_discs(view.conditions, row, mechanism));
}

FreeSprings loose_springs_of(const Conditions& conditions, const Mechanism& mechanism) {
  FreeSprings loose(mechanism.springs.size(), false);
  for (const Parameter& p : conditions.parameters)
    if (p.owner_kind == ParameterOwner::spring && p.slot > 0) loose[static_cast<std::size_t>(p.index)] = true;
  return loose;
}

}  // namespace balance
