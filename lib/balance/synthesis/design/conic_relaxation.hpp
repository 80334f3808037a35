#pragma once
/// What no design of one geometry is better than, whatever its numbers between their bounds.
///
/// The cone program of the masses (inner_problem) at a fixed geometry. Where a number that moves a CoM stands in products with a mass,
/// mass and first moment are the unknowns, and the place is within its box if and only if the first moment is within mass times
/// the box: nothing is lost by it (McCormick's inequalities are exact for a product whose one factor occurs nowhere else).

#include "balance/synthesis/design/convex_mass_model.hpp"
#include "balance/synthesis/design/inner_problem.hpp"

namespace balance::design {

/// Rows that are left with less than this, in their scale, can be met.
inline constexpr double relaxed_residual_tolerance = 1e-8;

/// Some of all designs: numbers [SI] between narrower bounds, or equal to them.
struct VariableDomain {
  VectorX lower, upper;
  std::vector<std::pair<VectorX, double>>
      linear_limits;  ///< coefficients · numbers ≤ limit; coefficients and numbers ≥ 0
};

struct RelaxationBound {
  bool is_feasible = false;  ///< false: there are none
  /// No design's is below them: the norm of what is left of the rows; the figure of those that meet the rows, or of all.
  double residual = std::numeric_limits<double>::quiet_NaN(), figure = std::numeric_limits<double>::quiet_NaN();
  VectorX x;  ///< numbers that come near it
};

class ConicRelaxation {
 public:
  /// @param rows scaled conditions × terms (list_terms) at the context's only geometry
  /// @param figures of the objective, at all samples; empty: none
  /// @param limits that all designs keep
  ConicRelaxation(const SolverContext& context, const MatrixX& rows, const std::vector<AffineFigure>& figures,
                  const std::vector<ConvexLimit>& limits);

  /// Numbers that are no unknowns.
  const std::vector<int>& outer() const { return model_.outer(); }
  /// No number but those that are fixed in the context is left out of the program.
  bool is_complete() const;
  RelaxationBound minimise_residual(const VariableDomain& part) const;
  /// @return no figure where rows cannot be met
  RelaxationBound minimise_constrained_figure(const VariableDomain& part) const;
  /// Whether the rows are met or not.
  RelaxationBound minimise_figure(const VariableDomain& part) const;

 private:
  /// Unknowns that stand still, with their values.
  using FixedUnknowns = std::vector<std::pair<Eigen::Index, double>>;
  struct ProgramResult {
    ConeStatus status = ConeStatus::failed;
    double bound = 0;  ///< of the program's cost
    VectorX unknowns;
  };
  ProgramResult solve(const VariableDomain& part, bool figures, bool rows, double weight) const;
  RelaxationBound minimise_penalised(const VariableDomain& part, bool rows) const;
  double max_violation(const VectorX& unknowns, bool rows) const;
  InnerData restrict_data(const VariableDomain& part, FixedUnknowns& held) const;
  RelaxationBound make_bound(const ProgramResult& answer, const VariableDomain& part) const;

  const SolverContext& context_;
  ConvexMassModel model_;
  bool has_figure_;     ///< there is something to minimise
  bool known_ = false;  ///< what the terms are of the unknowns
  InnerData data_;
  double size_ = 1;  ///< of the figure
};

}  // namespace balance::design
