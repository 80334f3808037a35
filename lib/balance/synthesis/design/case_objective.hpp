#pragma once
/// Objectives and limits for load cases: the worst or the mean value over all cases.

#include "balance/motion/study/design_space.hpp"
#include "balance/synthesis/design/design_problem.hpp"
#include "balance/synthesis/design/objective_builder.hpp"

#include <string>
#include <vector>

namespace balance::design {

/// A design for several loads: one instance of the spec per load case, with numbers shared by all cases and numbers of
/// individual cases.
struct CaseSpace {
  std::vector<DesignSpace> cases;                ///< one per load; all have the same free numbers
  std::vector<FreeNumber> numbers;               ///< all variables: the shared ones, then the adapted ones case by case
  std::vector<std::vector<int>> variable_index;  ///< for each case and free number of the spec: its index in `numbers`

  /// Values of the free numbers of a case. @param x values of `numbers`
  VectorX values(std::size_t case_index, const VectorX& x) const;
  VectorX start_values() const;
  /// The space in which only the numbers `free_numbers` are free and the others are fixed at x.
  CaseSpace fix_others(const VectorX& x, const std::vector<int>& free_numbers) const;
};

/// @param space whose study has load cases
CaseSpace make_case_space(const DesignSpace& space);

/// The space at another load. @param loads values of design.cases.numbers [SI, parameters as written]
DesignSpace at_load(const DesignSpace& space, const VectorX& loads);

/// The values of design.cases.numbers in the spec itself.
VectorX nominal_load(const DesignSpace& space);

/// "cargo.mass = 0.5", in the units of the spec.
std::string load_text(const std::vector<study::LoadParameter>& numbers, const VectorX& loads);

/// A function of the parameters of all cases (disjoint_union) or of the numbers of the space.
/// @param loose as used for deriving the conditions of all cases
/// @throws std::invalid_argument as build_objective
Objective build_case_objective(const CaseSpace& space, const std::vector<ObjectiveTerm>& terms,
                               study::CaseAggregation across, const dynamics::FreeSprings& loose, MotionCache& cache);

/// Limits of `subject_to`, on the worst value or the mean over all cases (FigureLimit::aggregation).
/// @throws std::invalid_argument as build_objective
std::vector<DesignLimit> build_case_limits(const CaseSpace& space, const std::vector<study::FigureLimit>& limits,
                                           const dynamics::FreeSprings& loose, MotionCache& cache);

/// Indices of a case's parameters among those of all cases, and its loose springs.
struct CaseOffsets {
  std::vector<int> parameters;
  dynamics::FreeSprings loose;
};

/// Figures of all cases as convex functions of the parameters of all cases.
class CaseFigures {
 public:
  /// @param space must outlive this object @param loose as used for deriving the conditions of all cases
  CaseFigures(const CaseSpace& space, const dynamics::FreeSprings& loose);

  /// Whether the terms and their combination over the cases are such functions; the worst case of a sum of several
  /// terms is not.
  bool are_convex(const std::vector<ObjectiveTerm>& terms, study::CaseAggregation across) const;
  /// Whether each figure of a case is a statistic of an affine quantity, and `terms` returns each separately.
  bool are_affine(const std::vector<ObjectiveTerm>& terms, study::CaseAggregation across) const;
  /// @param terms convex as above @return std::nullopt if a case has no motion
  std::optional<std::vector<AffineFigure>> terms(const std::vector<ObjectiveTerm>& terms, study::CaseAggregation across,
                                                 FigureSampling sampling, const VectorX& x, MotionCache& cache) const;
  /// The limits that are convex in every case.
  std::vector<study::FigureLimit> select_convex_limits(const std::vector<study::FigureLimit>& limits) const;
  /// The limits once per case, or once for the mean. @return std::nullopt if a case has no motion
  std::optional<std::vector<ConvexLimit>> limits(const std::vector<study::FigureLimit>& limits, const VectorX& x,
                                                 MotionCache& cache) const;

 private:
  const CaseSpace& space_;
  std::vector<CaseOffsets> offsets_;
  Eigen::Index parameter_count_;
};

}  // namespace balance::design
