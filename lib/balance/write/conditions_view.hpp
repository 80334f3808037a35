#pragma once
/// Everything that is told about a mechanism's conditions, gathered for the writers.

#include "balance/conditions/naming.hpp"
#include "balance/study/design_space.hpp"

#include <functional>
#include <string>
#include <vector>

namespace balance {

struct ConditionsView {
  std::string title;     ///< the mechanism's name
  std::string strategy;  ///< "complete" or "modular"
  Conditions conditions;
  ConditionNames names;
  VectorX residuals;                        ///< scaled, with the numbers that the study holds
  std::vector<bool> by_definition;          ///< per condition: no disc can miss it, and it is met
  std::vector<FreeNumber> numbers;          ///< the study's free ones
  std::vector<std::vector<int>> occurring;  ///< per condition: into `numbers`

  bool is_met(int row) const;
};

/// Fills residuals and by_definition from the rest.
/// @param mechanism whose numbers the residuals are for
void judge(ConditionsView& view, const Mechanism& mechanism, const LooseSprings& loose = {});

/// Which springs conditions describe by all products of stiffness and end points.
LooseSprings loose_springs_of(const Conditions& conditions, const Mechanism& mechanism);

}  // namespace balance
