#pragma once
/// What `minimize` asks for where there are load cases: its worst or its mean value over all of them.

#include "balance/analysis/case_space.hpp"
#include "balance/analysis/objective.hpp"
#include "balance/design/problem.hpp"

namespace balance {

/// Of the parameters of all cases side by side (side_by_side), or of the numbers of the space.
/// @param loose as the conditions of the whole are derived with
/// @throws std::invalid_argument as build_objective
Objective build_case_objective(const CaseSpace& space, const std::vector<ObjectiveTerm>& terms, CaseAggregation across,
                               const FreeSprings& loose);

/// What `subject_to` asks for: what counts of a figure is its worst value over all cases, or their mean (FigureLimit::across).
/// @throws std::invalid_argument as build_objective
std::vector<DesignLimit> build_case_limits(const CaseSpace& space, const std::vector<FigureLimit>& limits,
                                           const FreeSprings& loose);

/// Those among them that are convex functions of the parameters along any motion, once for every case, or once for the mean of all.
/// @param known how many of the limits they are
std::function<std::optional<std::vector<ConvexLimit>>(const VectorX& x)> build_case_convex_limits(
    const CaseSpace& space, const std::vector<FigureLimit>& limits, const FreeSprings& loose, int& known);

/// An objective as convex figures. @return null if a term is none, or for the worst of sums of several terms
std::function<std::optional<std::vector<AffineFigure>>(const VectorX& x)> build_case_convex_terms(
    const CaseSpace& space, const std::vector<ObjectiveTerm>& terms, CaseAggregation across, const FreeSprings& loose,
    FigureSampling samples = FigureSampling::coarse);

}  // namespace balance
