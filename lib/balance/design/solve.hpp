#pragma once
/// Finds numbers that balance a mechanism, or the best compromise and the reason why there is nothing better.

#include "balance/conditions/impossibility.hpp"
#include "balance/design/problem.hpp"

namespace balance {

enum class DesignStatus {
  unsolved,
  balanced,    ///< all conditions are met
  compromise,  ///< they are not, and whether they can be is not known
  impossible,  ///< they cannot be: `proof` or `unmet_fixed` says why; the numbers are the best compromise
};

/// What the solution rests on.
enum class DesignMethod {
  nothing_to_do,  ///< no condition depends on a free number
  affine,         ///< conditions affine in the numbers: linear algebra and bounds
  polynomial,     ///< Gauss–Newton on inertial numbers
  geometric,      ///< Gauss–Newton on lengths or ratios too
};

struct DesignOutcome {
  DesignStatus status = DesignStatus::unsolved;
  DesignMethod method = DesignMethod::nothing_to_do;
  std::string reason;                       ///< one or two sentences for the user
  VectorX x;                                ///< the free numbers' values
  Conditions conditions;                    ///< at x's geometry
  VectorX before, after;                    ///< scaled residuals at the start values and at x
  std::vector<std::vector<int>> occurring;  ///< per condition: free numbers that it depends on
  std::vector<int> unmet_fixed;             ///< conditions that no free number changes and that are not met
  std::vector<int> open;                    ///< conditions that x leaves open
  std::optional<Impossibility> proof;
  double objective = std::numeric_limits<double>::quiet_NaN();        ///< at x
  double objective_start = std::numeric_limits<double>::quiet_NaN();  ///< at the start values
  double lower_bound =
      std::numeric_limits<double>::quiet_NaN();  ///< of the objective over all exact solutions, if proved
  bool global = false;                           ///< the bound proves x the best there is
  std::vector<std::string> notes;
};

/// Scaled residual below which a condition counts as met.
inline constexpr double met = 1e-10;

/// In this order: conditions affine in the numbers, polynomial ones by Gauss–Newton with restarts, the best of the exact
/// solutions by the objective, a compromise by a global and a local search. Bodies stay physical throughout.
/// @throws std::invalid_argument for bounds that are not finite or do not hold the start value, and for search options out of
///         range
DesignOutcome solve(const DesignProblem& problem);

/// Springs of zero free length whose ends are free numbers: with their products as parameters (problem.options.loose_springs)
/// the conditions do not depend on the free numbers. solve() adds them by itself; objectives of parameters see the
/// parameters as listed with problem.options, so that whoever builds them from forces asks here first.
LooseSprings find_loose_springs(const DesignProblem& problem);

}  // namespace balance
