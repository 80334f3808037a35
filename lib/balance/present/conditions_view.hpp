#pragma once
/// Everything that is told about a mechanism's conditions, gathered for the writers.

#include "balance/analysis/what_stays.hpp"
#include "balance/conditions/naming.hpp"
#include "balance/study/design_space.hpp"

#include <functional>
#include <string>
#include <vector>

namespace balance {

struct ConditionsReportData {
  std::string title;     ///< the mechanism's name
  std::string strategy;  ///< "complete" or "modular"
  Conditions conditions;
  ConditionNames names;
  VectorX residuals;                                  ///< scaled, with the numbers that the study holds
  std::vector<bool> holds_by_definition;              ///< per condition: no disc can miss it, and it is met
  std::vector<FreeNumber> numbers;                    ///< the study's free ones
  std::vector<std::vector<int>> free_number_indices;  ///< per condition: into `numbers`

  std::vector<UnbalancedRemainder> unbalanced_remainder;  ///< what nothing balances
  std::vector<GeometricSymbol> known_terms;               ///< values of the known terms that occur

  bool is_met(int row) const;
  /// Conditions that hold a parameter; those behind them hold known terms alone and are told by `staying`.
  int parameter_rows() const { return static_cast<int>(conditions.parameter_rows()); }
};

/// Fills residuals, by_definition, known and staying from the rest.
/// @param mechanism whose numbers the residuals are for
/// @param trajectories along which efforts that stay are looked for
/// @param options as the conditions were derived
void evaluate_conditions(ConditionsReportData& view, const Mechanism& mechanism,
                         const std::vector<Trajectory>& trajectories, const ConditionOptions& options);

/// Which springs conditions describe by all products of stiffness and end points.
FreeSprings loose_springs_of(const Conditions& conditions, const Mechanism& mechanism);

}  // namespace balance
