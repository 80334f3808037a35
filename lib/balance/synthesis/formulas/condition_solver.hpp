#pragma once
/// Solves polynomial conditions for named symbols, as far as they are linear in these, one after the other.
///
/// In each step a condition that is linear in an unknown, a u + b = 0, is solved for it, u = −b / a, and substituted in
/// all others: Gauss's elimination over rational functions for conditions that are linear in several unknowns, and
/// substitution for those that become linear only after another one is known. Cancelling common divisors leaves what
/// Cramer's rule gives. The results are substituted in the conditions as they were, which decides what remains.

#include "balance/synthesis/formulas/polynomial_division.hpp"

#include <vector>

namespace balance::formulas {

struct SolvedUnknown {
  int symbol = 0;
  RationalFunction value;  ///< without any solved unknown
};

enum class UnsolvedReason {
  absent,           ///< it occurs in no condition
  undetermined,     ///< it is free: the conditions that contain it determine others
  nonlinear,        ///< the conditions that remain contain it, but none is linear in it
  vanishing_slope,  ///< what multiplies it in a condition that remains vanishes with the spec's numbers
};

struct UnsolvedUnknown {
  int symbol = 0;
  UnsolvedReason reason = UnsolvedReason::absent;
};

struct ConditionSolution {
  std::vector<SolvedUnknown> solved;  ///< in the order in which the unknowns were named
  std::vector<UnsolvedUnknown> unsolved;
  /// Factors of the denominators, which must not vanish; then those without which other values are solutions, too.
  std::vector<Polynomial> nonzero;
  /// What must vanish besides, with the solution substituted. A number other than zero: a contradiction.
  std::vector<Polynomial> remaining;
};

/// @param conditions polynomials in symbols that must vanish
/// @param unknowns symbols; conditions that determine fewer of them are solved for those named first
/// @throws FormulaError if polynomials become too long
ConditionSolution solve_conditions(const std::vector<Polynomial>& conditions, const std::vector<int>& unknowns);

}  // namespace balance::formulas
