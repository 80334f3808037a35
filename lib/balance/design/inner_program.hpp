#pragma once
/// The cone program of the masses at one geometry. Private to design.

#include "balance/design/inertial_model.hpp"

namespace balance::designing {

/// A figure of the unknowns and a one behind them.
struct InnerFigure {
  LinearFigure figure;
  double size = 1;  ///< its values are counted in it
  int limit = -1;   ///< of which limit it is a part; −1: of what is minimised
};

/// One geometry.
struct InnerData {
  InertialTerms terms;
  MatrixX rows;   ///< R
  VectorX right;  ///< r
  std::vector<InnerFigure> figures;
  VectorX bounds = {};  ///< per limit, in its figures' size
  std::optional<double> least_beyond =
      {};  ///< what the worst limit is missed by costs itself, or this; else each costs
};

/// Where a figure's rows stand in the program.
struct FigurePiece {
  std::size_t figure = 0, series = 0;
  Eigen::Index first = 0, rows = 0;  ///< of slack and multipliers
};

/// [matrix, constant]
MatrixX with_one(const MatrixX& matrix, const VectorX& constant);

/// The figure as one of the unknowns instead of the parameters.
LinearFigure of_unknowns(const LinearFigure& figure, const InertialTerms& terms);
/// Adds the parameters that occur in figures.
void mark_what_matters(const std::vector<LinearFigure>& figures, std::vector<bool>& matters);

/// Unknowns, the epigraphs of figures that are no sums, by how much limits are missed, the epigraph of the residual.
class InnerProgram {
 public:
  /// @param data must outlive the program
  InnerProgram(const InnerData& data, bool figures, bool residual);

  /// What is demanded of the unknowns themselves.
  void add_limits();
  void add_figure(std::size_t index, std::vector<FigurePiece>& pieces);
  /// After all figures: what a limit is missed by costs `weight` times as much. @return of the slack, where the limits' rows are
  Eigen::Index add_bounds(double weight);
  /// @return the orthonormal basis in which R w − r stands behind the residual's epigraph
  MatrixX add_residual(double weight);
  ConeProgram finish(std::vector<FigurePiece>& pieces) const;

  Eigen::Index unknowns() const { return n_; }
  /// Of the slack, where the residual's rows begin.
  Eigen::Index first_of_residual() const { return rows_.linear() + residual_ + 1; }

 private:
  MatrixX padded(const MatrixX& rows) const;
  void add_bound(Eigen::Index l, Eigen::Index missed);
  void add_peak(const PlaceRows& one, double size, Eigen::Index t);
  void add_norm(const MatrixX& rows, double size, Eigen::Index t);

  const InnerData& data_;
  Eigen::Index n_, variables_, epigraph_, residual_ = 0;
  ConeRows rows_;
  VectorX cost_, right_;  ///< right sides of the limits
  MatrixX bounded_;       ///< their rows
};

}  // namespace balance::designing
