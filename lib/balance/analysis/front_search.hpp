#pragma once
/// Single designs of a front, out of one budget. Private to analysis.

#include "balance/analysis/front_study.hpp"
#include "balance/analysis/load_case_study.hpp"

#include <optional>

namespace balance {

/// min figure `minimized`, the others within `limits`.
struct EpsilonConstraint {
  int minimized = 0;
  VectorX limits;  ///< per figure; NaN: none
  VectorX start;   ///< free numbers; empty: the spec's
};

class EpsilonConstraintSearch {
 public:
  /// @param planned searches that the budget is shared among
  EpsilonConstraintSearch(const DesignSpace& space, const DesignStudyOptions& options, int planned);

  int figure_count() const { return static_cast<int>(request_.figures.size()); }
  /// Without limits. @return none was found
  std::optional<ParetoPoint> solve(const EpsilonConstraint& wish);
  /// What the last search found, if it was no design.
  DesignReport failure() const;
  /// Completes a point with what its design does with the loads of all cases.
  void add_load_cases(ParetoPoint& point) const;
  bool is_budget_exhausted() const { return stopped_; }
  int search_count() const { return searches_; }
  VectorX no_limits() const;

 private:
  bool has_cases() const { return base_.start.design.cases.size() > 0; }
  DesignSpace space_for(const EpsilonConstraint& wish) const;
  DesignStudyOptions options_for_one();
  void search(ParetoPoint& point, const DesignStudyOptions& options) const;
  VectorX values_at(const VectorX& x) const;

  ParetoRequest request_;
  DesignSpace base_;  ///< asks for the first figure alone
  DesignStudyOptions options_;
  std::optional<LoadCaseStudy> cases_;
  DesignProblem problem_;
  std::vector<Objective> merits_;
  ParetoPoint failure_;
  double begin_, before_ = 0;  ///< [s] of computing: at the start, spent in searches that are over
  int planned_, searches_ = 0;
  bool stopped_ = false;
};

}  // namespace balance
