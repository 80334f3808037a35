#pragma once
/// Closures and prescribed quantities as one square system with a fixed sparsity pattern: the counterpart of
/// ConstraintSystem for hot loops. Rows that are lengths are divided by the characteristic length, columns that are
/// lengths multiplied by it.

#include "balance/foundation/numerics/min_singular_value.hpp"
#include "balance/foundation/numerics/overdetermined_system.hpp"
#include "balance/foundation/numerics/regularity.hpp"
#include "balance/foundation/numerics/square_system.hpp"
#include "balance/mechanics/kinematics/drive.hpp"
#include "balance/mechanics/trajectory/drive_sample.hpp"

#include <cstddef>
#include <vector>

namespace balance::kinematics {

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
  /// Whether the drive cannot determine the motion, whatever the lengths.
  bool structurally_singular() const { return structurally_singular_; }

  /// Writes the matrix and the residual at the poses in `state`.
  void evaluate(const TreeState<S>& state, const T* y, const trajectory::DriveSampleOf<T>& target, T* residual);
  /// @param min_pivot smallest pivot that counts as regular
  /// @return false if the matrix is singular
  bool factorise(double min_pivot = numerics::singular_pivot_threshold);
  /// Smallest pivot of the matrix last factorised, a measure of regularity.
  double regularity() const { return regularity_; }
  /// Solves for `columns()` unknowns in place of `rows()` right-hand sides; the result is unscaled. Array length:
  /// maximum of both.
  void solve(T* x);
  /// Two right-hand sides at little more than the cost of one.
  void solve_pair(T* x, T* z);
  /// Solves the transposed system in place: `columns()` generalised forces to `rows()` multipliers. Only for
  /// independent constraints.
  void solve_transposed(T* x);
  /// Stores the matrix last factorised for is_near_stored().
  void store();
  /// Whether every matrix on the straight line from the stored one to the one last factorised is regular by a margin:
  /// the norm of the latter's pseudo-inverse times their difference is at most `limit` < 1.
  /// See docs/theory.md, section 2.
  bool is_near_stored(double limit);
  /// Smallest singular value of the scaled matrix last evaluated.
  T min_singular_value();
  /// The same, also for a matrix near a singular one. Leaves the factors unchanged.
  double distance_to_singularity() const;
  /// Number of calls of evaluate().
  long evaluation_count() const { return evaluations_; }

  /// Right-hand sides for rates and accelerations. State: for the latter, velocities and velocity-product
  /// accelerations.
  void velocity_rhs(const trajectory::DriveSampleOf<T>& target, T* out) const;
  void acceleration_rhs(const TreeState<S>& state, const trajectory::DriveSampleOf<T>& target, T* out) const;

  /// Entry of the scaled matrix last evaluated.
  T entry(int row, int column) const { return redundant_ ? overdetermined_.at(row, column) : square_.at(row, column); }
  /// Storage index of an entry inside the sparsity pattern, for entry_at(): saves the look-up in hot loops.
  int entry_index(int row, int column) const {
    return redundant_ ? row * columns() + column : square_.index(row, column);
  }
  /// Equations with the same id, which is never 0, have the same storage indices.
  std::size_t pattern_id() const { return pattern_id_; }
  const T& entry_at(int storage_index) const {
    return (redundant_ ? overdetermined_.storage() : square_.storage())[storage_index];
  }
  /// The whole scaled matrix.
  MatrixX dense() const;
  /// The square system itself; not for redundant constraints.
  numerics::SquareSystem<T>& system() { return square_; }
  const numerics::SquareSystem<T>& system() const { return square_; }

 private:
  struct MatrixEntry {
    int index;            ///< into the storage
    bool is_accumulated;  ///< an earlier node of the same row moves the same column
  };

  void build_pattern();
  void fill_closures(const TreeState<S>& state, T* residual);
  void evaluate_speed_sum(const Closure<Constants<S>>& closure, const TreeState<S>& state, const MatrixEntry* entry);
  void fill_point(const TreeState<S>& state, const trajectory::DriveSampleOf<T>& target, T* residual);
  void fill_com(const TreeState<S>& state, const trajectory::DriveSampleOf<T>& target, T* residual);
  void fill_rotation(const TreeState<S>& state, const trajectory::DriveSampleOf<T>& target, T* residual);
  T* storage() { return redundant_ ? overdetermined_.storage() : square_.storage(); }
  void write_entry(const MatrixEntry& entry, const T& value) {
    T& entry_value = storage()[entry.index];
    entry_value = entry.is_accumulated ? entry_value + value : value;
  }
  std::vector<MatrixEntry> make_row_entries(const std::vector<NodeId>& nodes, int row);

  const Tree<Constants<S>>& tree_;
  const Drive<Constants<S>>& drive_;
  bool redundant_;
  bool structurally_singular_ = false;
  std::size_t pattern_id_ = 0;
  double regularity_ = 0;
  std::vector<double> row_scale_, column_scale_;
  std::vector<double> node_scale_;                         ///< per node: scale of the column that it moves
  std::vector<std::vector<MatrixEntry>> closure_entries_;  ///< per closure: path × rows
  std::vector<std::vector<MatrixEntry>> point_entries_;    ///< per point row: along the tool's path
  std::vector<std::vector<MatrixEntry>> com_entries_;      ///< per com row: all moving nodes
  std::vector<std::vector<MatrixEntry>> rotation_entries_;
  std::vector<NodeId> moving_nodes_;  ///< nodes that are not welds
  MassDistribution<S> masses_;
  Matrix3Of<T> rotation_jacobian_ = Matrix3Of<T>::Identity();  ///< of the tool's rotation at the last evaluation
  numerics::SquareSystem<T> square_;
  numerics::MinSingularValue min_singular_value_;
  numerics::OverdeterminedSystem<T> overdetermined_;
  long evaluations_ = 0, factorised_evaluation_ = -1;  ///< the latter: evaluation_count() of the matrix last factorised
};

extern template class KinematicEquations<Planar>;
extern template class KinematicEquations<Spatial>;

/// A second matrix that must stay regular along a motion, besides the one that determines it.
template <class S>
class RegularityMonitor {
 public:
  virtual ~RegularityMonitor() = default;

  /// Factorises the matrix at the configuration at which the equations were last evaluated.
  /// @return its smallest pivot, 0 if it is singular
  virtual double factorise(const KinematicEquations<S>& equations) = 0;
  /// Stores the matrix last factorised.
  virtual void store() = 0;
  /// Whether every matrix on the straight line from the stored one to the one last factorised is regular; see
  /// KinematicEquations::is_near_stored.
  virtual bool is_near_stored(double limit) = 0;

  /// The mobility that the motion would have if the monitored quantities drove it: the smallest singular value of the
  /// closures and their rows, at the equations' last evaluation. Leaves the stored matrix unchanged.
  virtual double mobility(const KinematicEquations<S>& equations) const = 0;
  /// Number of these quantities that could be omitted one at a time; 0 if none can.
  virtual std::size_t redundant_count() const = 0;
  /// Singular values, in decreasing order, of that matrix without one of the quantities; as many as columns if it has
  /// enough rows.
  virtual VectorX singular_values_without(std::size_t quantity, const KinematicEquations<S>& equations) const = 0;
};

}  // namespace balance::kinematics
