#pragma once
/// One search for a design, with limits as inequalities.

#include "balance/synthesis/design/solve_design.hpp"

namespace balance::design {

struct SingleSolve {
  DesignOutcome outcome;  ///< nothing is said of limits
  bool is_convex =
      false;  ///< the objective over all designs that meet the conditions and keep the limits: a proof can be had
};

SingleSolve solve_once(const DesignProblem& problem);

}  // namespace balance::design
