#pragma once
/// Lower level of the design search: the optimal masses at given lengths, and the derivatives of the optimum by the
/// lengths.
///
/// Minimises figure + ρ |R w − r| over the unknowns w subject to their constraints. The rows R belong to fixed
/// configurations, so everything is smooth in the lengths, even where the rank of the conditions drops. The penalty is
/// exact because it is a norm and not its square: for sufficiently large ρ the residual vanishes whenever possible.
/// Violations of limits on figures are penalised likewise. Derivatives by the lengths follow from the multipliers
/// (envelope theorem).

#include "balance/synthesis/design/convex_mass_model.hpp"

namespace balance::design {

// The cone program for the masses at one geometry.

/// A figure as a function of the unknowns followed by a 1.
struct InnerFigure {
  AffineFigure figure;
  double scale = 1;      ///< unit of its values
  int limit_index = -1;  ///< the limit that it belongs to; −1: the objective
};

/// Data at one geometry.
struct InnerData {
  AffineTerms terms;
  MatrixX rows;   ///< R
  VectorX right;  ///< r
  std::vector<InnerFigure> figures;
  VectorX limit_bounds = {};  ///< per limit, in units of its figures
  std::optional<double> violation_floor =
      {};  ///< if set, minimise the largest violation, but at least this; else penalise each violation
};

/// Position of a figure's rows in the program.
struct FigureRows {
  std::size_t figure = 0, series = 0;
  Eigen::Index first = 0, rows = 0;  ///< in slack and multipliers
};

/// [matrix, constant]
MatrixX append_constant_column(const MatrixX& matrix, const VectorX& constant);

/// Rewrites a figure of the parameters as one of the unknowns.
AffineFigure express_in_unknowns(const AffineFigure& figure, const AffineTerms& terms);
/// Marks the parameters that occur in the figures.
void mark_active_parameters(const std::vector<AffineFigure>& figures, std::vector<bool>& is_active_parameter);

/// Variables: the unknowns, epigraphs of the figures that are not sums, violations of limits, epigraph of the residual.
class InnerProgramBuilder {
 public:
  /// @param data must outlive the program
  InnerProgramBuilder(const InnerData& data, bool figures, bool residual);

  /// Adds the constraints on the unknowns themselves.
  void add_unknown_constraints();
  void add_figure(std::size_t index, std::vector<FigureRows>& pieces);
  /// To be called after all figures. Violations of limits cost `weight` per unit. @return first row of the limits in
  /// the slack
  Eigen::Index add_limits(double weight);
  /// @return orthonormal basis in which the rows after the residual's epigraph represent R w − r
  MatrixX add_residual(double weight);
  numerics::ConeProgram build(std::vector<FigureRows>& pieces) const;

  Eigen::Index unknowns() const { return n_; }
  /// First row of the residual in the slack.
  Eigen::Index first_of_residual() const { return rows_.linear_row_count() + residual_row_ + 1; }

 private:
  MatrixX pad_columns(const MatrixX& rows) const;
  void add_bound(Eigen::Index l, Eigen::Index violation);
  void add_bounds(const AffineSeries& series, bool is_magnitude, double scale, Eigen::Index t);
  void add_norm(const MatrixX& rows, double scale, Eigen::Index t);

  const InnerData& data_;
  Eigen::Index n_, variables_, epigraph_, residual_row_ = 0;
  numerics::ConeProgramBuilder rows_;
  VectorX cost_, limit_rhs_;  ///< right-hand sides of the limits
  MatrixX limit_rows_;        ///< their rows
};

struct InnerSolution {
  bool is_found = false;
  VectorX u;                                   ///< only the outer variables are meaningful
  VectorX unknowns;                            ///< w
  VectorX residual_vector;                     ///< R w − r
  double residual = 0, figure = 0, value = 0;  ///< |R w − r|, weighted sum [SI], minimised value
  numerics::ConeProgram program;
  numerics::ConeSolution cone;
  std::vector<FigureRows> pieces;    ///< of the figures
  Eigen::Index first_limit_row = 0;  ///< in the multipliers
  VectorX residual_multipliers;      ///< of `residual_vector`
};

class InnerProblem {
 public:
  enum class Target { residual, figure, both };

  /// @param figure_scale unit of the figure's values
  /// @param limit_margin margin of the limits, relative to their bounds
  InnerProblem(const SolverContext& context, const ConvexMassModel& model, Target target, double figure_scale,
               double limit_margin = 0);

  /// From now on, conditions are evaluated at configurations of this mechanism. @return false if there are none
  bool set_reference(const VectorX& u);
  InnerSolution solve_at(const VectorX& u) const;
  /// d value / d outer variables, in the model's order. Not finite next to points where the mechanism cannot be
  /// assembled.
  VectorX gradient(const InnerSolution& solution) const;
  /// d residual_vector / d outer variables, without the part that unconstrained unknowns can compensate. Not finite as
  /// above.
  MatrixX reduced_jacobian(const InnerSolution& solution) const;

 private:
  bool wants_figure() const { return target_ != Target::residual; }
  bool wants_residual() const { return target_ != Target::figure; }
  std::optional<InnerData> make_data(const VectorX& u) const;
  bool add_figures(const VectorX& u, InnerData& data) const;
  void evaluate_solution(const InnerData& data, InnerSolution& solution) const;
  double lagrangian(const InnerSolution& solution, const InnerData& data) const;
  MatrixX free_directions(const InnerSolution& solution) const;
  MatrixX differences(const VectorX& u, Eigen::Index rows,
                      const std::function<VectorX(const InnerData&)>& function) const;

  const SolverContext& context_;
  const ConvexMassModel& model_;
  Target target_;
  double figure_scale_, limit_margin_;
  std::optional<conditions::GoalResidual> goal_;
};

}  // namespace balance::design
