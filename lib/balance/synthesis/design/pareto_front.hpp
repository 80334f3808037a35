#pragma once
/// Pareto front of two or three figures: designs that cannot improve in one figure without getting worse in another.
/// Private helpers are in pareto_front.cpp; docs/theory.md derives the method.

#include "balance/synthesis/design/design_study.hpp"

#include <optional>
#include <string>
#include <vector>

namespace balance::design {

/// A design of the front: no design was found with a smaller figure `minimized` while the others are within `limits`.
struct ParetoPoint {
  DesignSpace space;    ///< asks for this design alone: one figure to minimise, the others as limits
  DesignReport report;  ///< without comparisons; its start values are those of the search
  VectorX values;       ///< of each figure [SI]
  VectorX all_cases;    ///< free numbers of all load cases (CaseSpace::numbers); empty: single load
  int minimized = 0;    ///< index of a figure
  VectorX limits;       ///< of each figure [SI]; NaN: none
  /// Proved lower bound of that figure over all designs within `limits`; NaN if unknown. A bound over all lengths leaves
  /// the limits out, which only lowers it.
  double lower_bound = std::numeric_limits<double>::quiet_NaN();
  /// proved_global if the gap is below 1e-5 of the figure's extent over the front; else as reported by the search.
  Optimality optimality = Optimality::not_optimised;
  /// Upper bound of the distance to the front in that figure; NaN: unknown.
  double gap() const { return values[minimized] - lower_bound; }
};

/// Optimum of a single figure.
struct ParetoAnchor {
  double min_value = std::numeric_limits<double>::quiet_NaN();    ///< best value found [SI]
  double lower_bound = std::numeric_limits<double>::quiet_NaN();  ///< for all designs, if proved
  Optimality optimality = Optimality::not_optimised;
  std::optional<certificate::LengthBound> length_bound;  ///< over all lengths, if there is one; for what it covers
};

struct ParetoFront {
  std::vector<ParetoAnchor> anchors;  ///< one per figure
  std::vector<ParetoPoint> points;    ///< sorted by the first figure, ascending; none dominates another
  DesignReport failure;               ///< why there are no points
  int searches = 0;                   ///< number of designs searched for
  bool is_budget_exhausted = false;   ///< the time limit was reached, or the search was interrupted
  std::vector<std::string> notes;
};

/// Computes the front: the optimum of each figure alone (with the others as small as that allows) and designs between
/// them, spread over the front. options.search.max_time and options.on_progress refer to all of them together.
/// @throws std::invalid_argument if the spec does not ask for a front, and as run_design_study
ParetoFront compute_pareto_front(const DesignSpace& space, const DesignStudyOptions& options);

/// Index of the point closest to the ideal point (the best value of each figure), relative to the extents of the front.
/// @throws std::invalid_argument if there are no points
int find_compromise_point(const ParetoFront& front);

/// The design of a point as reported by run_design_study; `before` holds the start values of the spec.
DesignReport make_pareto_design(const DesignSpace& space, const ParetoPoint& point, bool trajectories);

/// Whether a is nowhere above b and below it somewhere, by more than `slack` (one per figure).
bool dominates(const VectorX& a, const VectorX& b, const VectorX& slack);

}  // namespace balance::design
