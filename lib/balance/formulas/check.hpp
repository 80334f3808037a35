#pragma once
/// Holds printed formulas against the engine.

#include "balance/formulas/sheet.hpp"
#include "balance/inverse/inverse_dynamics.hpp"

#include <cstdint>
#include <map>
#include <string>

namespace balance::formulas {

struct Check {
  int states = 0;
  double error = 0;  ///< largest, as part of the terms that were added up
  bool agrees = false;
  std::string reason;  ///< one sentence if it could not be done, or does not agree
};

/// A value for every name that formulas have, at a pose.
/// @param y per column of the tree [rad or m]
std::map<std::string, double> names_at(const Sheet& sheet, const std::vector<double>& y);

/// Reads the texts of inertia, velocity and weight back at random states that close the loops, and compares what they say with
/// InverseDynamics: M and h of M q̈ + h in the independent coordinates. Closures take part, since they are what reduces the tree.
/// @param texts by label, as printed; labels that are missing count as the polynomials that they stand for
Check check_against_engine(const Sheet& sheet, const std::map<std::string, std::string>& texts,
                           const Mechanism& mechanism, int states = 5, std::uint64_t seed = 1);

}  // namespace balance::formulas
