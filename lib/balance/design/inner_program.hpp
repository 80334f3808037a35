#pragma once
/// The cone program of the masses at one geometry. Private to design.

#include "balance/design/inertial_model.hpp"

namespace balance::design {

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

}  // namespace balance::design
