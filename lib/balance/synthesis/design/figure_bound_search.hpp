#pragma once
/// Designs with free lengths that minimise figures of forces along a motion, together with the bound over all lengths.

#include "balance/synthesis/certificate/length_bound.hpp"
#include "balance/synthesis/design/design_problem.hpp"
#include "balance/synthesis/design/solve_design.hpp"

namespace balance::design {

/// Whether the objective consists of figures of forces along motions, and of nothing else.
bool minimises_motion_figures(const std::vector<ObjectiveTerm>& terms);

/// Solves a problem of a spec: a search, which knows the bound of the whole box, and the bound with what it found.
/// @param terms the objective
/// @param bound set; with a reason if these figures cannot be bounded over all lengths
DesignOutcome solve_with_figure_bound(const DesignSpace& space, const std::vector<ObjectiveTerm>& terms,
                                      const DesignProblem& problem, certificate::LengthBound& bound);

}  // namespace balance::design
