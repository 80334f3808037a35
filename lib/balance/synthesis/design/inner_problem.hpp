#pragma once
/// The lower level of a design's search: the best masses for given lengths, and what other lengths would change of that.
///
/// Minimise figure + ρ |R w − r| over the unknowns w within their limits. The rows R are those of fixed configurations, so that
/// everything is smooth in the lengths, also where the rank of the conditions falls; as a norm and no square the penalty is
/// exact: with ρ large enough the residual vanishes wherever it can. So is what limits on figures are missed by. Rates of change
/// by lengths come from the multipliers (envelope theorem).

#include "balance/synthesis/design/convex_mass_model.hpp"

namespace balance::design {

// The cone program of the masses at one geometry.

/// A figure of the unknowns and a one behind them.
struct InnerFigure {
  AffineFigure figure;
  double scale = 1;      ///< its values are counted in it
  int limit_index = -1;  ///< of which limit it is a part; −1: of what is minimised
};

/// One geometry.
struct InnerData {
  AffineTerms terms;
  MatrixX rows;   ///< R
  VectorX right;  ///< r
  std::vector<InnerFigure> figures;
  VectorX limit_bounds = {};  ///< per limit, in its figures' size
  std::optional<double> violation_floor =
      {};  ///< what the worst limit is missed by costs itself, or this; else each costs
};

/// Where a figure's rows stand in the program.
struct FigureRows {
  std::size_t figure = 0, series = 0;
  Eigen::Index first = 0, rows = 0;  ///< of slack and multipliers
};

/// [matrix, constant]
MatrixX append_constant_column(const MatrixX& matrix, const VectorX& constant);

/// The figure as one of the unknowns instead of the parameters.
AffineFigure express_in_unknowns(const AffineFigure& figure, const AffineTerms& terms);
/// Adds the parameters that occur in figures.
void mark_active_parameters(const std::vector<AffineFigure>& figures, std::vector<bool>& matters);

/// Unknowns, the epigraphs of figures that are no sums, by how much limits are missed, the epigraph of the residual.
class InnerProgramBuilder {
 public:
  /// @param data must outlive the program
  InnerProgramBuilder(const InnerData& data, bool figures, bool residual);

  /// What is demanded of the unknowns themselves.
  void add_unknown_constraints();
  void add_figure(std::size_t index, std::vector<FigureRows>& pieces);
  /// After all figures: what a limit is missed by costs `weight` times as much. @return of the slack, where the limits' rows are
  Eigen::Index add_limits(double weight);
  /// @return the orthonormal basis in which R w − r stands behind the residual's epigraph
  MatrixX add_residual(double weight);
  ConeProgram build(std::vector<FigureRows>& pieces) const;

  Eigen::Index unknowns() const { return n_; }
  /// Of the slack, where the residual's rows begin.
  Eigen::Index first_of_residual() const { return rows_.linear_row_count() + residual_ + 1; }

 private:
  MatrixX pad_columns(const MatrixX& rows) const;
  void add_bound(Eigen::Index l, Eigen::Index missed);
  void add_peak(const AffineSeries& one, double size, Eigen::Index t);
  void add_norm(const MatrixX& rows, double size, Eigen::Index t);

  const InnerData& data_;
  Eigen::Index n_, variables_, epigraph_, residual_ = 0;
  ConeProgramBuilder rows_;
  VectorX cost_, right_;  ///< right sides of the limits
  MatrixX bounded_;       ///< their rows
};

struct InnerSolution {
  bool is_found = false;
  VectorX u;                                   ///< outer numbers; the others mean nothing
  VectorX unknowns;                            ///< w
  VectorX residual_vector;                     ///< R w − r
  double residual = 0, figure = 0, value = 0;  ///< |left|, weighted sum [SI], what was minimised
  ConeProgram program;
  ConeSolution cone;
  std::vector<FigureRows> pieces;    ///< of the figures
  Eigen::Index first_limit_row = 0;  ///< of the multipliers, where those of limits are
  VectorX residual_multipliers;      ///< multipliers of `left`
};

class InnerProblem {
 public:
  enum class Target { residual, figure, both };

  /// @param size of the figure: values are counted in it
  /// @param spare part of their bounds by which limits are to be kept
  InnerProblem(const SolverContext& context, const ConvexMassModel& model, Target aim, double size, double spare = 0);

  /// Conditions are asked of configurations of this mechanism from now on. @return false if there are none
  bool set_reference(const VectorX& u);
  InnerSolution solve_at(const VectorX& u) const;
  /// d value / d outer numbers, in the model's order; not finite next to where nothing can be assembled.
  VectorX gradient(const InnerSolution& solution) const;
  /// d left / d outer numbers, less what unknowns that no limit holds can undo. Not finite as above.
  MatrixX reduced_jacobian(const InnerSolution& solution) const;

 private:
  bool wants_figure() const { return aim_ != Target::residual; }
  bool wants_residual() const { return aim_ != Target::figure; }
  std::optional<InnerData> make_data(const VectorX& u) const;
  bool add_figures(const VectorX& u, InnerData& data) const;
  void evaluate_solution(const InnerData& data, InnerSolution& solution) const;
  double lagrangian(const InnerSolution& solution, const InnerData& data) const;
  MatrixX free_directions(const InnerSolution& solution) const;
  MatrixX differences(const VectorX& u, Eigen::Index rows, const std::function<VectorX(const InnerData&)>& of) const;

  const SolverContext& context_;
  const ConvexMassModel& model_;
  Target aim_;
  double figure_scale_, limit_margin_;
  std::optional<GoalResidual> goal_;
};

}  // namespace balance::design
