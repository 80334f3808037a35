#include "balance/design/inner_program.hpp"

#include "balance/base/factorizations.hpp"

#include <algorithm>
#include <cmath>

namespace balance::design {

namespace {

/// The triangle of [a, −b], so that |a w − b| takes few rows, and the basis that it is written in.
struct CompressedRows {
  MatrixX rows, basis;
};
CompressedRows compress_rows(const MatrixX& rows) {
  const Eigen::Index k = std::min(rows.rows(), rows.cols());
  const Eigen::HouseholderQR<MatrixX> qr(rows);
  CompressedRows result;
  result.rows = qr.matrixQR().topRows(k).triangularView<Eigen::Upper>();
  result.basis = qr.householderQ() * MatrixX::Identity(rows.rows(), k);
  return result;
}

/// Rows whose norm is the root of the mean square.
MatrixX weight_rows(const AffineSeries& one) {
  MatrixX rows = one.rows;
  for (Eigen::Index k = 0; k < one.time_weights.size(); ++k)
    rows.middleRows(k * one.components, one.components) *= std::sqrt(std::max(0.0, one.time_weights[k]));
  return rows;
}

/// Unknowns that say by how much limits are missed.
Eigen::Index count_violation_variables(const InnerData& data) {
  return data.violation_floor ? std::min<Eigen::Index>(1, data.limit_bounds.size()) : data.limit_bounds.size();
}

Eigen::Index count_variables(const InnerData& data, bool figures, bool residual) {
  Eigen::Index count = data.terms.matrix.cols() + (residual ? 1 : 0);
  if (figures)
    for (const InnerFigure& one : data.figures) count += one.figure.series.empty() ? 0 : 1;
  return count + (figures ? count_violation_variables(data) : 0);
}

}  // namespace

MatrixX append_constant_column(const MatrixX& matrix, const VectorX& constant) {
  MatrixX all(matrix.rows(), matrix.cols() + 1);
  all << matrix, constant;
  return all;
}

AffineFigure express_in_unknowns(const AffineFigure& figure, const AffineTerms& terms) {
  AffineFigure result{figure.weight, {}, figure.figure, {}};
  if (const Eigen::Index p = figure.coefficients.size(); p > 0) {
    result.coefficients =
        append_constant_column(terms.matrix.topRows(p), terms.constant.head(p)).transpose() * figure.coefficients;
    return result;
  }
  for (const AffineSeries& one : figure.series) {
    const Eigen::Index p = one.rows.cols() - 1;
    const MatrixX by_unknown = one.rows.leftCols(p) * terms.matrix.topRows(p);
    const VectorX rest = one.rows.leftCols(p) * terms.constant.head(p) + one.rows.col(p);
    result.series.push_back({append_constant_column(by_unknown, rest), one.components, one.time_weights});
  }
  return result;
}

void mark_active_parameters(const std::vector<AffineFigure>& figures, std::vector<bool>& matters) {
  for (const AffineFigure& figure : figures) {
    for (Eigen::Index k = 0; k < figure.coefficients.size(); ++k)
      if (figure.coefficients[k] != 0) matters[static_cast<std::size_t>(k)] = true;
    for (const AffineSeries& one : figure.series)
      for (Eigen::Index k = 0; k + 1 < one.rows.cols(); ++k)
        if (!one.rows.col(k).isZero(0)) matters[static_cast<std::size_t>(k)] = true;
  }
}

InnerProgramBuilder::InnerProgramBuilder(const InnerData& data, bool figures, bool residual)
    : data_(data),
      n_(data.terms.matrix.cols()),
      variables_(count_variables(data, figures, residual)),
      epigraph_(n_),
      rows_(variables_),
      cost_(VectorX::Zero(variables_)),
      right_(data.limit_bounds),
      bounded_(MatrixX::Zero(data.limit_bounds.size(), variables_)) {}

void InnerProgramBuilder::add_unknown_constraints() {
  const ConeProgram& limits = data_.terms.constraints;
  rows_.add_inequalities(pad_columns(limits.matrix.topRows(limits.linear_rows)), limits.rhs.head(limits.linear_rows));
  Eigen::Index row = limits.linear_rows;
  for (const Eigen::Index size : limits.cone_sizes) {
    rows_.add_cone(pad_columns(-limits.matrix.middleRows(row, size)), limits.rhs.segment(row, size));
    row += size;
  }
}

void InnerProgramBuilder::add_figure(std::size_t index, std::vector<FigureRows>& pieces) {
  const auto& [figure, size, limit] = data_.figures[index];
  if (figure.series.empty()) {
    const VectorX sum = figure.weight / size * figure.coefficients;
    if (limit < 0) return void(cost_.head(n_) += sum.head(n_));
    bounded_.row(limit).head(n_) += sum.head(n_).transpose();
    right_[limit] -= sum[n_];
    return;
  }
  const Eigen::Index t = epigraph_++;
  (limit < 0 ? cost_[t] : bounded_(limit, t)) = figure.weight;
  for (std::size_t s = 0; s < figure.series.size(); ++s) {
    const AffineSeries& one = figure.series[s];
    const bool linear = figure.figure == Statistic::peak && one.components == 1;
    const Eigen::Index before = linear ? rows_.linear_row_count() : rows_.conic_row_count();
    if (linear)
      add_peak(one, size, t);
    else if (figure.figure == Statistic::peak)
      for (Eigen::Index k = 0; k < one.time_weights.size(); ++k)
        add_norm(one.rows.middleRows(k * one.components, one.components), size, t);
    else
      add_norm(compress_rows(weight_rows(one)).rows, size, t);
    const Eigen::Index rows = (linear ? rows_.linear_row_count() : rows_.conic_row_count()) - before;
    pieces.push_back({index, s, linear ? before : -1 - before, rows});  // cones stand behind all linear rows
  }
}

Eigen::Index InnerProgramBuilder::add_limits(double weight) {
  const Eigen::Index first = rows_.linear_row_count(), missed = epigraph_;
  const std::optional<double>& worst = data_.violation_floor;
  epigraph_ += count_violation_variables(data_);
  for (Eigen::Index l = 0; l < right_.size(); ++l) add_bound(l, worst ? missed : missed + l);
  for (Eigen::Index k = missed; k < epigraph_; ++k) {
    cost_[k] = worst ? 1 : weight;
    rows_.add_inequalities(-VectorX::Unit(variables_, k), worst ? -*worst : 0);
  }
  return first;
}

/// Σ figures − missed ≤ bound
void InnerProgramBuilder::add_bound(Eigen::Index l, Eigen::Index missed) {
  VectorX row = bounded_.row(l).transpose();
  row[missed] = -1;
  rows_.add_inequalities(row, right_[l]);
}

MatrixX InnerProgramBuilder::add_residual(double weight) {
  const Eigen::Index s = variables_ - 1;
  cost_[s] = weight;
  const CompressedRows small = compress_rows(append_constant_column(data_.rows, -data_.right));
  residual_ = rows_.conic_row_count();
  add_norm(small.rows, 1, s);
  return small.basis;
}

ConeProgram InnerProgramBuilder::build(std::vector<FigureRows>& pieces) const {
  for (FigureRows& piece : pieces)
    if (piece.first < 0) piece.first = rows_.linear_row_count() + (-1 - piece.first);
  return rows_.build(cost_);
}

MatrixX InnerProgramBuilder::pad_columns(const MatrixX& rows) const {
  MatrixX all = MatrixX::Zero(rows.rows(), variables_);
  all.leftCols(rows.cols()) = rows;
  return all;
}

/// ± rows (w, 1) ≤ size · t
void InnerProgramBuilder::add_peak(const AffineSeries& one, double size, Eigen::Index t) {
  const Eigen::Index m = one.rows.rows();
  MatrixX rows = MatrixX::Zero(2 * m, variables_);
  rows.topLeftCorner(m, n_) = one.rows.leftCols(n_) / size;
  rows.bottomLeftCorner(m, n_) = -one.rows.leftCols(n_) / size;
  rows.col(t).setConstant(-1);
  VectorX limits(2 * m);
  limits << -one.rows.col(n_) / size, one.rows.col(n_) / size;
  rows_.add_inequalities(rows, limits);
}

/// |rows (w, 1)| ≤ size · t
void InnerProgramBuilder::add_norm(const MatrixX& rows, double size, Eigen::Index t) {
  MatrixX cone = MatrixX::Zero(rows.rows() + 1, variables_);
  cone(0, t) = 1;
  cone.bottomLeftCorner(rows.rows(), n_) = rows.leftCols(n_) / size;
  VectorX constant = VectorX::Zero(rows.rows() + 1);
  constant.tail(rows.rows()) = rows.col(n_) / size;
  rows_.add_cone(cone, constant);
}

}  // namespace balance::design
