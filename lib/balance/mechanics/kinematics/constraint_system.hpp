#pragma once
/// All equations that determine a configuration, loop closures first and prescribed quantities after them, as one
/// system, dense or sparse; and those that determine its rates, of which there are more if something rolls. For one-off
/// computations: assembly, ranks, end poses, and mechanisms with redundant constraints.

#include "balance/foundation/numerics/sparse_matrix.hpp"
#include "balance/mechanics/kinematics/drive.hpp"
#include "balance/mechanics/trajectory/drive_sample.hpp"

namespace balance::kinematics {

template <class S>
class ConstraintSystem {
 public:
  /// @param tree must outlive the system
  ConstraintSystem(const Tree<S>& tree, Drive<S> drive);

  int rows() const { return tree_.position_rows + drive_.row_count(); }
  int place_rows() const { return tree_.position_rows; }
  int closure_rows() const { return tree_.closure_rows; }
  int columns() const { return tree_.columns; }
  const Drive<S>& drive() const { return drive_; }
  const Tree<S>& tree() const { return tree_; }
  const TreeState<S>& state() const { return state_; }
  const MassDistribution<S>& masses() const { return masses_; }

  /// Residual and Jacobian at y. Lengths are divided by the characteristic length and columns that are lengths are
  /// multiplied by it, so that all entries are comparable numbers.
  void evaluate(const VectorX& y, const trajectory::DriveSample& target, VectorX& residual, MatrixX& jacobian);
  void evaluate(const VectorX& y, const trajectory::DriveSample& target, VectorX& residual,
                numerics::SparseMatrix& jacobian);

  /// The same Jacobian with the rows of velocity-level closures between those of the other closures and of the
  /// prescribed quantities. The admissible rates are those that it maps to zero, or to the prescribed rates.
  void velocity_jacobian(const VectorX& y, const trajectory::DriveSample& target, MatrixX& jacobian);

  /// Whether no joint is flipped at the configuration last evaluated.
  bool is_aligned() const;

  /// Present values of the driven quantities at the configuration last evaluated.
  trajectory::DriveSample measure(const VectorX& y) const;

 private:
  // add(row, column, value) accumulates: several values may belong to one entry
  template <class Add>
  void add_closures(VectorX& residual, const Add& add);
  template <class Add>
  void add_velocity_closures(const Add& add) const;
  template <class Add>
  void add_drive(const VectorX& y, const trajectory::DriveSample& target, int first_row, VectorX& residual,
                 const Add& add);

  const Tree<S>& tree_;
  Drive<S> drive_;
  TreeState<S> state_;
  MassDistribution<S> masses_;
  std::vector<Eigen::Triplet<double>> entries_;  ///< of the sparse Jacobian
};

extern template class ConstraintSystem<Planar>;
extern template class ConstraintSystem<Spatial>;

}  // namespace balance::kinematics
