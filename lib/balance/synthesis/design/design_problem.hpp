#pragma once
/// A design problem: which numbers are free, which goals they are to meet, what to prefer among exact solutions.

#include "balance/motion/study/search_options.hpp"
#include "balance/synthesis/conditions/conditions.hpp"
#include "balance/synthesis/design/trajectory_cost.hpp"

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace balance {

/// A free number.
struct DesignVariable {
  std::string name;  ///< key path in the spec
  double lower = 0, upper = 0, start = 0;
  std::vector<double> discrete_values =
      {};  ///< the only values that it may have, increasing; empty: any between its bounds
};

/// An element that a design may leave out: without mass, inertia and stiffness, which vanish where these numbers are zero.
struct OptionalElement {
  std::string name;
  std::vector<int> variables;  ///< positions among the variables
};

/// Elements of one kind, of which a design keeps only so many.
struct CardinalityConstraint {
  std::string kind;  ///< "counterweights"
  std::vector<OptionalElement> elements;
  int max_count =
      -1;  ///< that are kept; −1: as few, of all choices without a number together, as meet goals and limits
};

/// weight · the largest of several smooth functions of the free numbers.
struct MaxTerm {
  double weight = 1;
  VectorX values;
  MatrixX jacobian;  ///< one row per function, one column per number
};

/// A figure to be made small. Exactly one of the two functions is set.
struct Objective {
  std::string name;  ///< "added mass", "rms(torque) along cycloid"
  std::string unit;
  /// Of the parameters alone (Conditions::parameters' order); cheap. Writes the gradient if the pointer is not null.
  std::function<double(const VectorX& parameters, VectorX* gradient)> of_parameters;
  /// Of the free numbers, by simulation: where the motion itself depends on them. NaN where it cannot be computed: such numbers
  /// are no design.
  std::function<double(const VectorX& x)> of_variables;
  /// Why of_variables has no value at x, a sentence. May be empty.
  std::function<std::string(const VectorX& x)> failure_reason;
  bool is_convex = false;  ///< of_parameters is convex
  bool is_secondary =
      false;  ///< of the design (added mass), not of its motion: smallest when nothing is balanced at all, so that
              ///< a compromise first meets the conditions as well as it can
  bool is_constant = false;                                       ///< of_parameters is, whatever the parameters
  double lower_bound = -std::numeric_limits<double>::infinity();  ///< no value is below it, whatever the numbers
};

/// A figure that a design must keep to.
struct DesignLimit {
  std::string text;  ///< "peak(torque) <= 12"
  Objective figure;
  bool is_lower = false;  ///< else at most
  double bound = 0;       ///< [SI]
};

/// Σ figures ≤ bound, figures being functions of the parameters.
struct ConvexLimit {
  std::vector<AffineFigure> figures;
  double bound = 0;  ///< [SI]
};

/// What a search has done so far.
struct SearchProgress {
  double seconds = 0, max_time = 0;  ///< of computing
  int starts = 0, local_searches = 0, geometries = 0, evaluations = 0;
};

struct DesignProblem {
  std::vector<DesignVariable> variables;
  /// The mechanism at values of the free numbers within their bounds; not checked for physical sense.
  std::function<Mechanism(const VectorX& x)> build_mechanism;
  /// The first fault (validate) of the mechanism there, a sentence: such numbers are no design. Empty: there is none. Null: nothing is
  /// asked.
  std::function<std::string(const VectorX& x)> invalidity_reason;
  std::vector<CardinalityConstraint> cardinality_constraints;  ///< what may be left out
  std::vector<Goal> goals;                                     ///< none: only the objective is asked for
  ConditionOptions options;
  /// derive_conditions, or the modular strategy's.
  std::function<Conditions(const Mechanism&, const std::vector<Goal>&, const ConditionOptions&)> derive_conditions;
  bool is_modular = false;  ///< conditions come from `derive` at every geometry, not from GoalResidual
  /// Why numbers are no design whatever they balance: the mechanism cannot be assembled, or not make a motion that it is there
  /// for. Empty: they may be one. Asked where lengths or ratios are free; null: nothing is asked.
  std::function<std::string(const VectorX& x)> infeasibility_reason;
  /// The objective where only the numbers `kept` change and the others stay as in x; may know more of it than the whole one.
  /// Null: the objective itself is used.
  std::function<Objective(const VectorX& x, const std::vector<int>& kept, const FreeSprings& loose)>
      objective_at_geometry;
  /// One of many: no proofs and no more than a few starts.
  bool is_subproblem = false;
  std::optional<Objective> objective;  ///< among exact solutions; also judges compromises
  std::vector<DesignLimit> limits;     ///< all must hold
  /// `limits` as objective_at_geometry. Null: the limits themselves are used.
  std::function<std::vector<DesignLimit>(const VectorX& x, const std::vector<int>& kept, const FreeSprings& loose)>
      limits_at_geometry;
  /// The limits of that kind at the lengths and along the motion of x, as figures_at; all are needed for one limit that load cases
  /// repeat. Null: none is of the kind.
  std::function<std::optional<std::vector<ConvexLimit>>(const VectorX& x)> convex_limits;
  int convex_limit_count = 0;  ///< of the limits, how many convex_limits knows
  /// The objective is how far beyond its bound the worst of convex_limits is, in parts of the bound (of one, if that is zero), or this,
  /// if that is more.
  std::optional<double> violation_floor;
  SearchOptions search;
  /// Asked now and then while something is searched for; false ends the search, which gives what it has. May be null.
  std::function<bool(const SearchProgress&)> on_progress;
  /// The objective's terms at the lengths and along the motion of x, as functions of the parameters; may sample the motion
  /// more coarsely than the objective does. Nothing where there is no motion. Null: they are not such functions.
  std::function<std::optional<std::vector<AffineFigure>>(const VectorX& x)> convex_terms_at;
  /// The same from all samples.
  std::function<std::optional<std::vector<AffineFigure>>(const VectorX& x)> all_convex_terms_at;
  /// The objective as a sum of maxima, of one function or of several, with slopes. Nothing where it has no value. Null: slopes are not
  /// known.
  std::function<std::optional<std::vector<MaxTerm>>(const VectorX& x)> max_terms;
};

}  // namespace balance
