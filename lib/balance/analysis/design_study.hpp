#pragma once
/// A whole design: conditions, numbers that meet them, and every trajectory before and after.

#include "balance/design/solve.hpp"
#include "balance/result/result.hpp"
#include "balance/study/design_space.hpp"

#include <string>
#include <vector>

namespace balance {

struct DesignStudyOptions {
  bool modular = false;                 ///< the chains one by one (P0 section 2.2) instead of the complete conditions
  std::vector<Goal> goals;              ///< empty: the spec's; none there either: only `minimize`
  std::vector<std::string> without;     ///< what the goals leave out (ConditionOptions)
  std::vector<ObjectiveTerm> minimize;  ///< empty: the spec's
  SearchOptions search;
  bool trajectories = true;  ///< compare the spec's trajectories before and after
};

/// One trajectory before and after. Whichever could not be followed has an outcome that says so and no samples.
struct TrajectoryComparison {
  std::string trajectory;
  Result before, after;
};

struct DesignReport {
  DesignOutcome outcome;
  std::vector<FreeNumber> numbers;  ///< as in the study
  /// Values of the free numbers in the mechanism before: its start values, as every other command uses them.
  VectorX before;
  Study study_before, study_after;
  double mass_before = 0, mass_after = 0;  ///< of everything that moves [kg]
  /// Sum of the moments of inertia of everything that moves, about the carrying bodies' frame origins (space: half the
  /// trace) [kg m^2].
  double inertia_before = 0, inertia_after = 0;
  /// Of counterweights and discs in the designed mechanism, against none at all [kg], [kg m^2].
  double added_mass = 0, added_inertia = 0;
  std::vector<TrajectoryComparison> comparisons;
  std::vector<std::string> notes;
};

/// @throws std::invalid_argument if there are no free numbers, neither a goal nor something to minimize, or the objective's
///         trajectory does not exist
DesignReport design_study(const DesignSpace& space, const DesignStudyOptions& options);

}  // namespace balance
