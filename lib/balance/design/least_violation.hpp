#pragma once
/// The design that is least beyond its limits, as a design problem without them. Private to design.

#include "balance/design/problem.hpp"

namespace balance::design {

/// The same goals and numbers; to be made small is the largest violation of a limit, down to a little within all of them.
/// @param problem its functions must live as long as what is returned
DesignProblem make_phase_one_problem(const DesignProblem& problem);

/// A figure of a problem at values of the free numbers; NaN where it has none.
double evaluate_figure(const DesignProblem& problem, const Objective& figure, const VectorX& x);

}  // namespace balance::design
