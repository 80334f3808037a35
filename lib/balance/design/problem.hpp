#pragma once
/// A design problem: which numbers are free, which goals they are to meet, what to prefer among exact solutions.

#include "balance/conditions/conditions.hpp"
#include "balance/result/linear_figure.hpp"
#include "balance/study/search_options.hpp"

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace balance {

/// A free number.
struct Variable {
  std::string name;  ///< key path in the spec
  double lower = 0, upper = 0, start = 0;
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
  std::function<std::string(const VectorX& x)> trouble;
  bool convex = false;  ///< of_parameters is convex
  bool size =
      false;  ///< of the design (added mass), not of its motion: smallest when nothing is balanced at all, so that
              ///< a compromise first meets the conditions as well as it can
};

struct DesignProblem {
  std::vector<Variable> variables;
  /// The mechanism at values of the free numbers within their bounds; not checked for physical sense.
  std::function<Mechanism(const VectorX& x)> mechanism_at;
  std::vector<Goal> goals;  ///< none: only the objective is asked for
  ConditionOptions options;
  /// derive_conditions, or the modular strategy's.
  std::function<Conditions(const Mechanism&, const std::vector<Goal>&, const ConditionOptions&)> derive;
  bool modular = false;  ///< conditions come from `derive` at every geometry, not from GoalResidual
  /// Why numbers are no design whatever they balance: the mechanism cannot be assembled, or not make a motion that it is there
  /// for. Empty: they may be one. Asked where lengths or ratios are free; null: nothing is asked.
  std::function<std::string(const VectorX& x)> obstacle;
  /// The objective where only the numbers `kept` change and the others stay as in x; may know more of it than the whole one.
  /// Null: the objective itself is used.
  std::function<Objective(const VectorX& x, const std::vector<int>& kept, const LooseSprings& loose)> objective_at;
  /// One of many: no proofs and no more than a few starts.
  bool inner = false;
  std::optional<Objective> objective;  ///< among exact solutions; also judges compromises
  SearchOptions search;
  /// The objective's terms at the lengths and along the motion of x, as functions of the parameters; may sample the motion
  /// more coarsely than the objective does. Nothing where there is no motion. Null: they are not such functions.
  std::function<std::optional<std::vector<LinearFigure>>(const VectorX& x)> figures_at;
};

}  // namespace balance
