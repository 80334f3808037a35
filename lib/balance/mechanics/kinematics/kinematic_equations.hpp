#pragma once
/// Closures and prescribed quantities as one square system with a fixed sparsity: the hot loop's counterpart of System. Rows
/// that are lengths are divided by the characteristic length, columns that are lengths multiplied by it.

#include "balance/foundation/numerics/min_singular_value.hpp"
#include "balance/foundation/numerics/overdetermined_system.hpp"
#include "balance/foundation/numerics/regularity.hpp"
#include "balance/foundation/numerics/square_system.hpp"
#include "balance/mechanics/kinematics/drive.hpp"
#include "balance/mechanics/trajectory/drive_sample.hpp"

#include <cstddef>
#include <vector>

namespace balance {

template <class S>
class KinematicEquations {
 public:
  using T = typename S::Scalar;

  /// @param redundant more rows than columns: least squares on the dense matrix instead of a sparse factorisation
  KinematicEquations(const Tree<Constants<S>>& tree, const Drive<Constants<S>>& drive, bool redundant);

  int rows() const { return static_cast<int>(row_scale_.size()); }
  int columns() const { return static_cast<int>(column_scale_.size()); }
  const std::vector<double>& column_scale() const { return column_scale_; }
  const std::vector<double>& row_scale() const { return row_scale_; }
  /// No choice of lengths could make the drive determine the motion.
  bool structurally_singular() const { return structurally_singular_; }

  /// Writes the matrix and the residual at the poses in `state`.
  void evaluate(const TreeState<S>& state, const T* y, const DriveSampleOf<T>& target, T* residual);
  /// @param least smallest pivot that counts as regular
  /// @return false if the matrix is singular
  bool factorise(double least = singular_pivot_threshold);
  /// Smallest pivot of the matrix last factorised, a measure of regularity.
  double regularity() const { return regularity_; }
  /// Turns `rows()` right-hand sides into `columns()` unknowns, in place, unscaled on return. Array length: max of both.
  void solve(T* x);
  /// Two right-hand sides at little more than the cost of one.
  void solve_pair(T* x, T* z);
  /// `columns()` right-hand sides into `rows()` unknowns of the transposed system, in place: generalised forces into multipliers.
  /// Only where the constraints are independent.
  void solve_transposed(T* x);
  /// Remembers the matrix last factorised for is_near_stored().
  void store();
  /// Whether every matrix on the straight way from the kept one to the one last factorised is regular by a margin: the
  /// pseudo-inverse of the latter times their difference is at most `limit` < 1. See docs/theory.md, section 2.
  bool is_near_stored(double limit);
  /// Smallest singular value of the scaled matrix last filled.
  T min_singular_value();
  /// The same, of a matrix near a singular one too. Remembers nothing.
  double distance_to_singularity() const;
  /// Counts the calls of evaluate().
  long evaluation_count() const { return evaluations_; }

  /// Right-hand sides for rates and accelerations. State: for the latter velocities and velocity-caused accelerations.
  void velocity_rhs(const DriveSampleOf<T>& target, T* out) const;
  void acceleration_rhs(const TreeState<S>& state, const DriveSampleOf<T>& target, T* out) const;

  /// Entry of the scaled matrix last filled.
  T entry(int row, int column) const { return redundant_ ? tall_.at(row, column) : sparse_.at(row, column); }
  /// The place of an entry that may be other than zero, for value(): saves the look-up in a hot loop.
  int entry_index(int row, int column) const {
    return redundant_ ? row * columns() + column : sparse_.index(row, column);
  }
  /// Equations with the same number, never 0, have the same places.
  std::size_t pattern_id() const { return layout_; }
  const T& entry_at(int place) const { return (redundant_ ? tall_.storage() : sparse_.storage())[place]; }
  /// All of it.
  MatrixX dense() const;
  /// The square system itself; not of redundant constraints.
  SquareSystem<T>& system() { return sparse_; }
  const SquareSystem<T>& system() const { return sparse_; }

 private:
  struct MatrixEntry {
    int index;            ///< into the storage
    bool is_accumulated;  ///< an earlier node of the same row moves the same column
  };

  void build_pattern();
  void fill_closures(const TreeState<S>& state, T* residual);
  void evaluate_speed_sum(const Closure<Constants<S>>& closure, const TreeState<S>& state, const MatrixEntry* entry);
  void fill_point(const TreeState<S>& state, const DriveSampleOf<T>& target, T* residual);
  void fill_com(const TreeState<S>& state, const DriveSampleOf<T>& target, T* residual);
  void fill_rotation(const TreeState<S>& state, const DriveSampleOf<T>& target, T* residual);
  T* storage() { return redundant_ ? tall_.storage() : sparse_.storage(); }
  void write_entry(const MatrixEntry& entry, const T& value) {
    T& at = storage()[entry.index];
    at = entry.is_accumulated ? at + value : value;
  }
  std::vector<MatrixEntry> entries_of(const std::vector<NodeId>& nodes, int row);

  const Tree<Constants<S>>& tree_;
  const Drive<Constants<S>>& drive_;
  bool redundant_;
  bool structurally_singular_ = false;
  std::size_t layout_ = 0;
  double regularity_ = 0;
  std::vector<double> row_scale_, column_scale_;
  std::vector<double> node_scale_;                         ///< per node: scale of the column that it moves
  std::vector<std::vector<MatrixEntry>> closure_entries_;  ///< per closure: path × rows
  std::vector<std::vector<MatrixEntry>> point_entries_;    ///< per point row: along the tool's path
  std::vector<std::vector<MatrixEntry>> com_entries_;      ///< per com row: all moving nodes
  std::vector<std::vector<MatrixEntry>> rotation_entries_;
  std::vector<NodeId> moving_nodes_;  ///< nodes that are no welds
  MassDistribution<S> masses_;
  Matrix3Of<T> rotation_jacobian_ = Matrix3Of<T>::Identity();  ///< of the tool's rotation where last filled
  SquareSystem<T> sparse_;
  MinSingularValue min_singular_value_;
  OverdeterminedSystem<T> tall_;
  long evaluations_ = 0, factorised_evaluation_ = -1;  ///< the latter: evaluation_count() of the matrix last factorised
};

extern template class KinematicEquations<Planar>;
extern template class KinematicEquations<Spatial>;

/// A second matrix that must stay regular along a motion, beside the one that determines it.
template <class S>
class RegularityMonitor {
 public:
  virtual ~RegularityMonitor() = default;

  /// Factorises the matrix at the configuration that the equations are filled at.
  /// @return its smallest pivot, 0 if it is singular
  virtual double factorise(const KinematicEquations<S>& equations) = 0;
  /// Remembers the matrix last looked at.
  virtual void store() = 0;
  /// Whether every matrix on the straight way from the one kept to the one last looked at is regular; see
  /// KinematicEquations::is_near_stored.
  virtual bool is_near_stored(double limit) = 0;

  /// The mobility that the motion would have if the guard's quantities drove it: the smallest singular value of the closures and their
  /// rows. Remembers nothing. Equations: as above.
  virtual double mobility(const KinematicEquations<S>& equations) const = 0;
  /// How many of these quantities could be left out one at a time; 0 if none can.
  virtual std::size_t redundant_count() const = 0;
  /// Singular values, largest first, of that matrix without one of the quantities: as many as columns where that has enough rows.
  virtual VectorX singular_values_without(std::size_t quantity, const KinematicEquations<S>& equations) const = 0;
};

}  // namespace balance
