#pragma once
/// Which numbers of a spec the balancing conditions are solved for.

#include "balance/motion/study/balance_goal.hpp"
#include "balance/synthesis/conditions/coefficient_names.hpp"
#include "balance/synthesis/formulas/condition_solver.hpp"
#include "balance/synthesis/formulas/symbolic_tree.hpp"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace balance::formulas {

/// One number of the spec: a parameter, or a number of the mechanism.
struct UnknownNumber {
  std::string name;       ///< as requested
  std::string parameter;  ///< its name in the spec; empty: a number of the mechanism
  std::string path;       ///< `counterweights.cw1.at[0]`
};

/// The numbers that names mean: parameters; symbols of formulas (`lg1`, `x_cw1`), also of numbers that are zero; paths
/// in the spec with or without their section, where a vector's path stands for all its components.
/// @throws std::invalid_argument for a name that means no number
std::vector<UnknownNumber> find_unknown_numbers(const Mechanism& mechanism, const study::SpecNumberTexts& texts,
                                                const std::vector<std::string>& names);

struct SolveRequest {
  std::vector<Goal> goals;
  std::vector<UnknownNumber> unknowns;  ///< each must be an input of the spec's recording
  /// Derives the conditions of mechanisms with other numbers, which checks the solution.
  std::function<Conditions(const Mechanism&)> derive;
  /// The mechanism's conditions with named coefficients; needed unless has_symbolic_conditions().
  std::optional<Conditions> conditions;
  conditions::ConditionNames names;
};

/// What solving gave; symbols of the sheet's ring.
struct SolvedConditions {
  std::vector<Goal> goals;
  std::vector<UnknownNumber> unknowns;
  std::vector<int> symbols;  ///< per unknown
  std::vector<int> unnamed;  ///< coefficients that are numbers of this geometry
  std::optional<int> rank;   ///< of the conditions, if they were derived numerically
  ConditionSolution solution;
  std::function<Conditions(const Mechanism&)> derive;
};

}  // namespace balance::formulas
