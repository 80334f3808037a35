#pragma once
/// Compares printed formulas with the engine.

#include "balance/mechanics/dynamics/inverse_dynamics.hpp"
#include "balance/synthesis/formulas/formula_sheet.hpp"

#include <cstdint>
#include <map>
#include <string>

namespace balance::formulas {

struct FormulaCheck {
  int states = 0;
  int perturbed_states = 0;   ///< those with other numbers than the spec's
  double error = 0;           ///< maximum, relative to the terms that were added up
  int solution_states = 0;    ///< sets of other numbers at which a solution met the engine's conditions
  double solution_error = 0;  ///< maximum residual there, relative to the conditions' terms
  bool is_consistent = false;
  std::string reason;  ///< one sentence if the check was impossible or found a difference
  std::string note;    ///< one sentence if the formulas agree, but could not be compared with other numbers
};

struct FormulaCheckOptions {
  int states = 5;
  std::uint64_t seed = 1;
  bool with_perturbed_parameters = true;  ///< with other numbers, too; not if numbers replace symbols
};

/// Values of all names in the formulas at a pose.
/// @param y per column of the tree [rad or m]
std::map<std::string, double> evaluate_names(const FormulaSheet& sheet, const std::vector<double>& y);

/// Parses the texts of inertia, velocity and weight, evaluates them at random states that close the loops, and compares
/// them with InverseDynamics: M and h of M q̈ + h in the independent coordinates. The closures are part of this, since
/// they reduce the tree's equations. Some states are those of the mechanism with the spec's numbers, others those of
/// mechanisms with other parameters and free numbers.
/// @param texts from texts_by_label; missing labels stand for the sheet's polynomials
FormulaCheck check_against_engine(const FormulaSheet& sheet, const std::map<std::string, std::string>& texts,
                                  const Mechanism& mechanism, const FormulaCheckOptions& options = {});

}  // namespace balance::formulas
