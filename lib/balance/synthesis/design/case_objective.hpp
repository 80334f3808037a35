#pragma once
/// What `minimize` asks for where there are load cases: its worst or its mean value over all of them.

#include "balance/motion/study/design_space.hpp"
#include "balance/synthesis/design/design_problem.hpp"
#include "balance/synthesis/design/objective_builder.hpp"

#include <string>
#include <vector>

namespace balance {

/// One design for several loads: the spec once for every load case, with numbers that all cases share and numbers of each case's own.
struct CaseSpace {
  std::vector<DesignSpace> cases;   ///< at the loads of the cases; all with the same free numbers
  std::vector<FreeNumber> numbers;  ///< of the whole: those that all share, then case by case the adapted ones
  std::vector<std::vector<int>> variable_index;  ///< per case and free number of the spec: its place among `numbers`

  /// Values of a case's free numbers. @param x of `numbers`
  VectorX values(std::size_t which, const VectorX& x) const;
  VectorX start_values() const;
  /// The space where only the numbers `kept` are free and the others stay at x.
  CaseSpace fix_others(const VectorX& x, const std::vector<int>& kept) const;
};

/// @param space its study has load cases
CaseSpace make_case_space(const DesignSpace& space);

/// The space at another load. @param loads values of design.cases.numbers [SI, parameters as written]
DesignSpace at_load(const DesignSpace& space, const VectorX& loads);

/// What the spec itself says of design.cases.numbers.
VectorX nominal_load(const DesignSpace& space);

/// "cargo.mass = 0.5", in the spec's units.
std::string load_text(const std::vector<LoadParameter>& numbers, const VectorX& loads);

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
