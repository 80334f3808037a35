#include "peer_efforts.hpp"

#include <Eigen/QR>

namespace balance::peers {

/// Pivots of the equations, relative to the largest, below which they depend on others: far above round-off, far below
/// the pivots of a regular state.
constexpr double dependence_threshold = 1e-8;

PeerEfforts::PeerEfforts(const RigidTree& tree, Peer& peer, const VectorX& x, const VectorX& dx, const VectorX& ddx)
    : peer_(peer), motions_(tree.motions_of_independent), efforts_(tree.efforts_on_independent) {
  peer.compute_tree_forces(x, dx, ddx);
  const MatrixX columns = (peer.compute_closure_jacobian() * motions_).transpose();
  if (columns.cols() > 0) {
    Eigen::ColPivHouseholderQR<MatrixX> qr(columns.rows(), columns.cols());
    qr.setThreshold(dependence_threshold);
    qr.compute(columns);
    for (Eigen::Index k = 0; k < qr.rank(); ++k) rows_.push_back(qr.colsPermutation().indices()[k]);
  }
  const Eigen::Index count = efforts_.rows();
  if (efforts_.cols() + static_cast<Eigen::Index>(rows_.size()) != count)
    throw NotComparable("has other numbers of actuators and of degrees of freedom");
  matrix_.resize(count, count);
  matrix_.leftCols(efforts_.cols()) = efforts_;
  for (std::size_t k = 0; k < rows_.size(); ++k) matrix_.col(efforts_.cols() + k) = columns.col(rows_[k]);
  Eigen::ColPivHouseholderQR<MatrixX> qr(matrix_);
  qr.setThreshold(dependence_threshold);
  if (qr.rank() < count) throw NotComparable("has actuators that do not hold it");
  if (rows_.empty()) open_tree_ = matrix_.inverse() * motions_.transpose();
}

const VectorX& PeerEfforts::compute(const VectorX& x, const VectorX& dx, const VectorX& ddx) {
  const VectorX& forces = peer_.compute_tree_forces(x, dx, ddx);
  if (rows_.empty()) {
    effort_.noalias() = open_tree_ * forces;
    return effort_;
  }
  const MatrixX& jacobian = peer_.compute_closure_jacobian();
  for (std::size_t k = 0; k < rows_.size(); ++k)
    matrix_.col(efforts_.cols() + k).noalias() = motions_.transpose() * jacobian.row(rows_[k]).transpose();
  right_side_.noalias() = motions_.transpose() * forces;
  lu_.compute(matrix_);
  solution_ = lu_.solve(right_side_);
  effort_ = solution_.head(efforts_.cols());
  return effort_;
}

}  // namespace balance::peers
