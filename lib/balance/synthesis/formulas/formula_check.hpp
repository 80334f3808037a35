#pragma once
/// Holds printed formulas against the engine.

#include "balance/mechanics/dynamics/inverse_dynamics.hpp"
#include "balance/synthesis/formulas/formula_sheet.hpp"

#include <cstdint>
#include <map>
#include <string>

namespace balance::formulas {

struct FormulaCheck {
  int states = 0;
  int perturbed_states = 0;  ///< of the states: at other numbers than the spec's
  double error = 0;          ///< largest, as part of the terms that were added up
  bool is_consistent = false;
  std::string reason;  ///< one sentence if it could not be done, or does not agree
  std::string note;    ///< one sentence if it agrees, but could not be compared at other numbers
};

struct FormulaCheckOptions {
  int states = 5;
  std::uint64_t seed = 1;
  bool with_perturbed_parameters = true;  ///< at other numbers, too: not where numbers stand in place of symbols
};

/// A value for every name that formulas have, at a pose.
/// @param y per column of the tree [rad or m]
std::map<std::string, double> evaluate_names(const FormulaSheet& sheet, const std::vector<double>& y);

/// Reads the texts of inertia, velocity and weight back at random states that close the loops, and compares what they say with
/// InverseDynamics: M and h of M q̈ + h in the independent coordinates. Closures take part, since they are what reduces the tree.
/// The states are some of the mechanism with the spec's numbers, and some of mechanisms whose parameters and free numbers are others.
/// @param texts as texts_by_label has them; labels that are missing count as the polynomials that they stand for
FormulaCheck check_against_engine(const FormulaSheet& sheet, const std::map<std::string, std::string>& texts,
                                  const Mechanism& mechanism, const FormulaCheckOptions& options = {});

}  // namespace balance::formulas
