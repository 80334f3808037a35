#pragma once
/// How numbers follow the load. Private to analysis.

#include "balance/analysis/load_case_runs.hpp"

namespace balance {

/// The law of adapted numbers, or a table of them, with what it takes to move what they move.
class AdaptiveStudy {
 public:
  /// @param space, options, judge must outlive the study
  /// @param x the free numbers at the spec's own load; those that are not adapted are for all loads
  /// @param found values of the adapted numbers per case
  AdaptiveStudy(const DesignSpace& space, const DesignStudyOptions& options, const LoadCaseEvaluator& judge,
                const VectorX& x, const MatrixX& found);

  /// Adapted numbers at a load: by the law where it keeps their bounds, else solved for.
  /// @param near where to start from
  VectorX adapted_values(const VectorX& loads, const VectorX& near) const;
  /// The same with the other free numbers.
  VectorX variable_values(const VectorX& loads) const;
  /// Everything but `fixed`.
  AdaptiveReport report() const;

 private:
  void find_law();
  AdaptedTable table() const;
  void find_value_ranges(AdaptiveReport& report) const;
  std::optional<double> adjustment_work() const;
  VectorX insert_adapted(const VectorX& adapted) const;
  bool is_within_bounds(const VectorX& adapted) const;
  const LoadCases& loads() const { return space_.start.design.cases; }

  const DesignSpace& space_;
  const DesignStudyOptions& options_;
  const LoadCaseEvaluator& judge_;
  VectorX x_;
  MatrixX found_;
  VectorX lower_, upper_;  ///< of the loads
  std::optional<AdaptiveLaw> law_;
};

}  // namespace balance
