#pragma once
/// Lower bounds for all designs at one geometry, with the variables anywhere between their bounds.
///
/// The cone program of the masses (inner_problem) at a fixed geometry. If a variable that moves a CoM is multiplied by
/// a mass, mass and first moment are the unknowns. The position is within its box if and only if the first moment is
/// within mass times the box. Nothing is lost by this: McCormick's inequalities are exact for a product one of whose
/// factors occurs nowhere else.

#include "balance/synthesis/design/convex_mass_model.hpp"
#include "balance/synthesis/design/inner_problem.hpp"

namespace balance::design {

/// Scaled residual below which rows count as satisfiable.
inline constexpr double relaxed_residual_tolerance = 1e-8;

/// A subset of all designs: variables [SI] between narrower bounds, which may coincide.
struct VariableDomain {
  VectorX lower, upper;
  std::vector<std::pair<VectorX, double>>
      linear_limits;  ///< coefficients · variables ≤ limit; coefficients and variables ≥ 0
};

struct RelaxationBound {
  bool is_feasible = false;  ///< false: the subset is empty
  /// Lower bounds for all designs: norm of the residual of the rows; figure of the designs that meet the rows, or of
  /// all designs.
  double residual = std::numeric_limits<double>::quiet_NaN(), figure = std::numeric_limits<double>::quiet_NaN();
  VectorX x;  ///< values that nearly attain the bounds
};

class ConicRelaxation {
 public:
  /// @param rows scaled conditions × terms (list_terms) at the only geometry of the context
  /// @param figures of the objective, at all samples; may be empty
  /// @param limits that all designs satisfy
  ConicRelaxation(const SolverContext& context, const MatrixX& rows, const std::vector<AffineFigure>& figures,
                  const std::vector<ConvexLimit>& limits);

  /// Variables that are not unknowns of the program.
  const std::vector<int>& outer() const { return model_.outer(); }
  /// Whether the program contains all variables except those fixed in the context.
  bool is_complete() const;
  RelaxationBound minimise_residual(const VariableDomain& domain) const;
  /// @return no figure if the rows cannot be met
  RelaxationBound minimise_constrained_figure(const VariableDomain& domain) const;
  /// Minimises the figure regardless of the rows.
  RelaxationBound minimise_figure(const VariableDomain& domain) const;

 private:
  /// Fixed unknowns with their values.
  using FixedUnknowns = std::vector<std::pair<Eigen::Index, double>>;
  struct ProgramResult {
    numerics::ConeStatus status = numerics::ConeStatus::failed;
    double bound = 0;  ///< lower bound of the cost
    VectorX unknowns;
  };
  ProgramResult solve(const VariableDomain& domain, bool figures, bool rows, double weight) const;
  RelaxationBound minimise_penalised(const VariableDomain& domain, bool rows) const;
  double max_violation(const VectorX& unknowns, bool rows) const;
  InnerData restrict_data(const VariableDomain& domain, FixedUnknowns& fixed) const;
  RelaxationBound make_bound(const ProgramResult& result, const VariableDomain& domain) const;

  const SolverContext& context_;
  ConvexMassModel model_;
  bool has_figure_;         ///< whether there is a figure to minimise
  bool has_terms_ = false;  ///< whether the terms could be expressed in the unknowns
  InnerData data_;
  double figure_scale_ = 1;  ///< of the figure
};

}  // namespace balance::design
