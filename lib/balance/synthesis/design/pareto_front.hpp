#pragma once
/// The trade-off between two or three figures: designs of which none can be better in one figure without being worse in another.
/// Private helpers are in pareto_front.cpp; docs/theory.md derives the method.

#include "balance/synthesis/design/design_study.hpp"

#include <string>
#include <vector>

namespace balance {

/// A design of the front: no design was found with the figure `minimized` smaller while the others are within `limits`.
struct ParetoPoint {
  DesignSpace space;    ///< that asks for this design alone: one figure to minimize, the others as limits
  DesignReport report;  ///< without comparisons; its starts are those of the search
  VectorX values;       ///< per figure [SI]
  VectorX all_cases;    ///< the free numbers of all load cases (CaseSpace::numbers); empty: one load
  int minimized = 0;    ///< index of a figure
  VectorX limits;       ///< per figure [SI]; NaN: none
  /// What no design within `limits` has less of in that figure, if proved; else NaN.
  double lower_bound = std::numeric_limits<double>::quiet_NaN();
  /// proved_global where the gap is below 1e-5 of the figure's extent over the front; else what the search says.
  Optimality optimality = Optimality::not_optimised;
  /// How far the point is from the front at most, in that figure; NaN: not known.
  double gap() const { return values[minimized] - lower_bound; }
};

/// What one figure alone comes to.
struct ParetoAnchor {
  double min_value = std::numeric_limits<double>::quiet_NaN();    ///< found [SI]
  double lower_bound = std::numeric_limits<double>::quiet_NaN();  ///< of all designs, if proved
  Optimality optimality = Optimality::not_optimised;
};

struct ParetoFront {
  std::vector<ParetoAnchor> anchors;  ///< per figure
  std::vector<ParetoPoint> points;    ///< by the first figure, rising; none dominates another
  DesignReport failure;               ///< where there are no points: why
  int searches = 0;                   ///< designs looked for
  bool is_budget_exhausted = false;   ///< time ran out, or the search was interrupted
  std::vector<std::string> notes;
};

/// All points: the best of each figure alone (the others then as small as that allows), and designs between them, spread over
/// the front. options.search.seconds and options.watch are for all of them together.
/// @throws std::invalid_argument if the spec asks for no front, and as run_design_study
ParetoFront compute_pareto_front(const DesignSpace& space, const DesignStudyOptions& options);

/// Index of the point that is nearest to the best in all figures at once, measured in parts of the front's extent.
/// @throws std::invalid_argument if there are no points
int find_compromise_point(const ParetoFront& front);

/// A point's design as run_design_study would report it, before being the spec's start values.
DesignReport make_pareto_design(const DesignSpace& space, const ParetoPoint& point, bool trajectories);

/// a is nowhere above b and somewhere below it, by more than `slack` (per figure).
bool dominates(const VectorX& a, const VectorX& b, const VectorX& slack);

}  // namespace balance
