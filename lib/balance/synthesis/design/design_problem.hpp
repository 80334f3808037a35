#pragma once
/// A design problem: free numbers, goals and, for choosing among exact solutions, an objective.

#include "balance/motion/study/search_options.hpp"
#include "balance/motion/study/study.hpp"
#include "balance/synthesis/design/design_model.hpp"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace balance::design {

/// A free number.
struct DesignVariable {
  std::string name;  ///< key path in the spec
  double lower = 0, upper = 0, start = 0;
  std::vector<double> discrete_values =
      {};  ///< the only admissible values, ascending; empty: all values between the bounds
};

/// An element that a design may leave out. Its mass, inertia and stiffness vanish if these variables are zero.
struct OptionalElement {
  std::string name;
  std::vector<int> variables;           ///< indices into the variables
  std::vector<int> own_variables = {};  ///< others that have no effect if the element is left out, such as its place
};

/// A limit on the number of elements of one kind that a design keeps.
struct CardinalityConstraint {
  std::string kind;  ///< "counterweights"
  std::vector<OptionalElement> elements;
  int max_count = -1;  ///< −1: the minimum number, over all such choices together, that meets goals and limits
};

/// Progress of a search.
struct SearchProgress {
  double seconds = 0, max_time = 0;  ///< CPU time
  int starts = 0, local_searches = 0, geometries = 0, evaluations = 0;
};

struct DesignProblem {
  std::vector<DesignVariable> variables;
  std::shared_ptr<const DesignModel> model;                    ///< must not be null when the problem is solved
  std::vector<CardinalityConstraint> cardinality_constraints;  ///< optional elements
  /// Variables that must have different sizes. Those of elements that are left out do not count.
  std::vector<study::DifferentNumbers> all_different;
  std::vector<Goal> goals;  ///< empty: only the objective matters
  ConditionOptions options;
  bool is_modular = false;  ///< the model derives conditions of the modular strategy
  /// The model derives conditions anew at every geometry, because their rows cannot be followed: those of the modular
  /// strategy, and those of orders in several load cases.
  bool derives_anew = false;
  /// Solve with few starts and without proofs, as one of many problems.
  bool is_subproblem = false;
  /// Search once, without asking whether independent starts agree: for one of several designs.
  bool is_single_pass = false;
  std::optional<Objective> objective;  ///< minimised among exact solutions; also judges compromises
  std::vector<DesignLimit> limits;     ///< all must hold
  /// Proved lower bound of the objective among the exact solutions within the limits. A search that reaches it ends.
  double proved_lower_bound = -std::numeric_limits<double>::infinity();
  /// If set, the objective is the maximum violation of the model's convex limits relative to their bounds (or to 1, if
  /// a bound is zero), but at least this value.
  std::optional<double> violation_floor;
  /// Values to which numbers without effect return [SI]; empty: the start values.
  VectorX settled_values = {};
  study::SearchOptions search;
  /// Called from time to time during a search; false ends the search, which returns its best result so far. May be
  /// null.
  std::function<bool(const SearchProgress&)> on_progress;
};

}  // namespace balance::design
