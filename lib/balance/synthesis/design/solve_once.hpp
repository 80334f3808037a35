#pragma once
/// A single design search, with limits as inequalities.

#include "balance/synthesis/design/solve_design.hpp"

namespace balance::design {

struct SingleSolve {
  DesignOutcome outcome;  ///< without limits
  bool is_convex =
      false;  ///< whether the objective is convex on a convex set of feasible designs, so that optimality can be proved
};

SingleSolve solve_once(const DesignProblem& problem);

}  // namespace balance::design
