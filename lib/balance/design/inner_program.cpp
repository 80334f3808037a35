#include "balance/design/inner_program.hpp"

#include "balance/base/factorizations.hpp"

#include <algorithm>
#include <cmath>

namespace balance::designing {

namespace {

/// The triangle of [a, −b], so that |a w − b| takes few rows, and the basis that it is written in.
struct Compressed {
  MatrixX rows, basis;
};
Compressed compressed(const MatrixX& rows) {
  const Eigen::Index k = std::min(rows.rows(), rows.cols());
  const Eigen::HouseholderQR<MatrixX> qr(rows);
  Compressed result;
  result.rows = qr.matrixQR().topRows(k).triangularView<Eigen::Upper>();
  result.basis = qr.householderQ() * MatrixX::Identity(rows.rows(), k);
  return result;
}

/// Rows whose norm is the root of the mean square.
MatrixX weighted(const PlaceRows& one) {
  MatrixX rows = one.rows;
  for (Eigen::Index k = 0; k < one.share.size(); ++k)
    rows.middleRows(k * one.components, one.components) *= std::sqrt(std::max(0.0, one.share[k]));
  return rows;
}

/// Unknowns that say by how much limits are missed.
Eigen::Index count_misses(const InnerData& data) {
  return data.least_beyond ? std::min<Eigen::Index>(1, data.bounds.size()) : data.bounds.size();
}

Eigen::Index count_variables(const InnerData& data, bool figures, bool residual) {
  Eigen::Index count = data.terms.matrix.cols() + (residual ? 1 : 0);
  if (figures)
    for (const InnerFigure& one : data.figures) count += one.figure.series.empty() ? 0 : 1;
  return count + (figures ? count_misses(data) : 0);
}

}  // namespace

MatrixX with_one(const MatrixX& matrix, const VectorX& constant) {
  MatrixX all(matrix.rows(), matrix.cols() + 1);
  all << matrix, constant;
  return all;
}

LinearFigure of_unknowns(const LinearFigure& figure, const InertialTerms& terms) {
  LinearFigure result{figure.weight, {}, figure.figure, {}};
  if (const Eigen::Index p = figure.coefficients.size(); p > 0) {
    result.coefficients = with_one(terms.matrix.topRows(p), terms.constant.head(p)).transpose() * figure.coefficients;
    return result;
  }
  for (const PlaceRows& one : figure.series) {
    const Eigen::Index p = one.rows.cols() - 1;
    const MatrixX by_unknown = one.rows.leftCols(p) * terms.matrix.topRows(p);
    const VectorX rest = one.rows.leftCols(p) * terms.constant.head(p) + one.rows.col(p);
    result.series.push_back({with_one(by_unknown, rest), one.components, one.share});
  }
  return result;
}

void mark_what_matters(const std::vector<LinearFigure>& figures, std::vector<bool>& matters) {
  for (const LinearFigure& figure : figures) {
    for (Eigen::Index k = 0; k < figure.coefficients.size(); ++k)
      if (figure.coefficients[k] != 0) matters[static_cast<std::size_t>(k)] = true;
    for (const PlaceRows& one : figure.series)
      for (Eigen::Index k = 0; k + 1 < one.rows.cols(); ++k)
        if (!one.rows.col(k).isZero(0)) matters[static_cast<std::size_t>(k)] = true;
  }
}

InnerProgram::InnerProgram(const InnerData& data, bool figures, bool residual)
    : data_(data),
      n_(data.terms.matrix.cols()),
      variables_(count_variables(data, figures, residual)),
      epigraph_(n_),
      rows_(variables_),
      cost_(VectorX::Zero(variables_)),
      right_(data.bounds),
      bounded_(MatrixX::Zero(data.bounds.size(), variables_)) {}

void InnerProgram::add_limits() {
  const ConeProgram& limits = data_.terms.limits;
  rows_.at_most(padded(limits.matrix.topRows(limits.linear)), limits.right.head(limits.linear));
  Eigen::Index row = limits.linear;
  for (const Eigen::Index size : limits.cones) {
    rows_.in_cone(padded(-limits.matrix.middleRows(row, size)), limits.right.segment(row, size));
    row += size;
  }
}

void InnerProgram::add_figure(std::size_t index, std::vector<FigurePiece>& pieces) {
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
    const PlaceRows& one = figure.series[s];
    const bool linear = figure.figure == Figure::peak && one.components == 1;
    const Eigen::Index before = linear ? rows_.linear() : rows_.conic();
    if (linear)
      add_peak(one, size, t);
    else if (figure.figure == Figure::peak)
      for (Eigen::Index k = 0; k < one.share.size(); ++k)
        add_norm(one.rows.middleRows(k * one.components, one.components), size, t);
    else
      add_norm(compressed(weighted(one)).rows, size, t);
    const Eigen::Index rows = (linear ? rows_.linear() : rows_.conic()) - before;
    pieces.push_back({index, s, linear ? before : -1 - before, rows});  // cones stand behind all linear rows
  }
}

Eigen::Index InnerProgram::add_bounds(double weight) {
  const Eigen::Index first = rows_.linear(), missed = epigraph_;
  const std::optional<double>& worst = data_.least_beyond;
  epigraph_ += count_misses(data_);
  for (Eigen::Index l = 0; l < right_.size(); ++l) add_bound(l, worst ? missed : missed + l);
  for (Eigen::Index k = missed; k < epigraph_; ++k) {
    cost_[k] = worst ? 1 : weight;
    rows_.at_most(-VectorX::Unit(variables_, k), worst ? -*worst : 0);
  }
  return first;
}

/// Σ figures − missed ≤ bound
void InnerProgram::add_bound(Eigen::Index l, Eigen::Index missed) {
  VectorX row = bounded_.row(l).transpose();
  row[missed] = -1;
  rows_.at_most(row, right_[l]);
}

MatrixX InnerProgram::add_residual(double weight) {
  const Eigen::Index s = variables_ - 1;
  cost_[s] = weight;
  const Compressed small = compressed(with_one(data_.rows, -data_.right));
  residual_ = rows_.conic();
  add_norm(small.rows, 1, s);
  return small.basis;
}

ConeProgram InnerProgram::finish(std::vector<FigurePiece>& pieces) const {
  for (FigurePiece& piece : pieces)
    if (piece.first < 0) piece.first = rows_.linear() + (-1 - piece.first);
  return rows_.finish(cost_);
}

MatrixX InnerProgram::padded(const MatrixX& rows) const {
  MatrixX all = MatrixX::Zero(rows.rows(), variables_);
  all.leftCols(rows.cols()) = rows;
  return all;
}

/// ± rows (w, 1) ≤ size · t
void InnerProgram::add_peak(const PlaceRows& one, double size, Eigen::Index t) {
  const Eigen::Index m = one.rows.rows();
  MatrixX rows = MatrixX::Zero(2 * m, variables_);
  rows.topLeftCorner(m, n_) = one.rows.leftCols(n_) / size;
  rows.bottomLeftCorner(m, n_) = -one.rows.leftCols(n_) / size;
  rows.col(t).setConstant(-1);
  VectorX limits(2 * m);
  limits << -one.rows.col(n_) / size, one.rows.col(n_) / size;
  rows_.at_most(rows, limits);
}

/// |rows (w, 1)| ≤ size · t
void InnerProgram::add_norm(const MatrixX& rows, double size, Eigen::Index t) {
  MatrixX cone = MatrixX::Zero(rows.rows() + 1, variables_);
  cone(0, t) = 1;
  cone.bottomLeftCorner(rows.rows(), n_) = rows.leftCols(n_) / size;
  VectorX constant = VectorX::Zero(rows.rows() + 1);
  constant.tail(rows.rows()) = rows.col(n_) / size;
  rows_.in_cone(cone, constant);
}

}  // namespace balance::designing
