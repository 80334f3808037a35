#include "balance/synthesis/design/row_space.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"

#include <algorithm>
#include <cmath>

namespace balance::design {

namespace {

/// Round-off of zeros, relative to the largest number involved.
constexpr double row_space_rank_tolerance = 1e-14;

}  // namespace

SequentialQr::SequentialQr(Eigen::Index columns)
    : work_(MatrixX::Zero(std::max<Eigen::Index>(3 * columns, 64), columns)), filled_(columns) {}

void SequentialQr::add(const Eigen::Ref<const MatrixX>& rows, double weight) {
  if (weight == 0) return;
  if (filled_ + rows.rows() > work_.rows()) reduce();
  work_.middleRows(filled_, rows.rows()) = std::sqrt(weight) * rows;
  filled_ += rows.rows();
}

void SequentialQr::reduce() {
  const Eigen::Index n = work_.cols();
  const MatrixX triangle = Eigen::HouseholderQR<MatrixX>(work_.topRows(filled_)).matrixQR().topRows(n);
  work_.topRows(n) = triangle.triangularView<Eigen::Upper>();
  filled_ = n;
}

MatrixX SequentialQr::triangle() {
  reduce();
  return work_.topRows(work_.cols());
}

RowSpace::RowSpace(const MatrixX& triangle, const ColumnScales& units) {
  const Eigen::Index n = triangle.cols();
  VectorX scale = units.scale;
  for (std::size_t f = 0; f < units.families.size(); ++f) {
    const Eigen::Index first = units.families[f], end = f + 1 < units.families.size() ? units.families[f + 1] : n;
    if (end == first) continue;
    const auto sizes = triangle.middleCols(first, end - first) * scale.segment(first, end - first).asDiagonal();
    const double largest = numerics::max_abs(MatrixX(sizes).colwise().norm());
    scale.segment(first, end - first) *= largest > 0 ? 1 / largest : 0;
  }
  const MatrixX scaled = triangle * scale.asDiagonal();
  for (Eigen::Index c = 0; c < n; ++c)
    if (scaled.col(c).norm() > row_space_rank_tolerance) active_.push_back(c);
  if (active_.empty()) return;
  const numerics::ColumnPivotingQr qr(MatrixX(scaled(Eigen::all, active_)));
  const auto width = static_cast<Eigen::Index>(active_.size());
  const MatrixX R = qr.matrixR().topRows(std::min(n, width)).triangularView<Eigen::Upper>();
  Eigen::Index rank = 0;
  while (rank < R.rows() && std::abs(R(rank, rank)) > row_space_rank_tolerance) ++rank;
  const auto& order = qr.colsPermutation().indices();
  coordinates_.resize(rank, width);
  for (Eigen::Index k = 0; k < width; ++k) {
    const Eigen::Index c = active_[static_cast<std::size_t>(order[k])];
    coordinates_.col(order[k]) = R.col(k).head(rank) / scale[c];
    if (k < rank) pivots_.push_back(c);
  }
  pivot_block_.resize(rank, rank);
  for (Eigen::Index k = 0; k < rank; ++k) pivot_block_.col(k) = coordinates_.col(order[k]);
}

/// At the pivot columns, F equals G times the pivot block of L.
MatrixX RowSpace::to_coordinates(const MatrixX& rows) const {
  const MatrixX pivots = rows(Eigen::all, pivots_);
  return pivot_block_.triangularView<Eigen::Upper>().solve<Eigen::OnTheRight>(pivots);
}

}  // namespace balance::design
