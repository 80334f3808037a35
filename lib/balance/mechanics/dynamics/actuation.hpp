#pragma once
/// From the tree's generalised forces to actuator efforts and loop multipliers: τ = Sᵀ u + Φᵀ λ, which is P0's projection
/// u = Cᵀ τ with C normalised on the actuated rows (P0 eq. 17, 29–34).

#include "balance/foundation/base/dual.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/overdetermined_system.hpp"
#include "balance/foundation/numerics/square_system.hpp"
#include "balance/mechanics/kinematics/kinematic_equations.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"

#include <optional>
#include <string>
#include <vector>

namespace balance {

// Efforts of least norm and, under them, multipliers of least norm, where actuators or closures are more than needed:
// Sᵀ u + Cᵀ λ = f.

// ---- matrices over numbers with derivatives ----

template <class T, int Rows, int Columns>
Eigen::Matrix<double, Rows, Columns> values_of(const Eigen::Matrix<T, Rows, Columns>& matrix) {
  return matrix.unaryExpr([](const T& x) { return value_of(x); });
}

/// Derivatives with respect to number k.
template <int N, int Rows, int Columns>
Eigen::Matrix<double, Rows, Columns> derivatives_of(const Eigen::Matrix<Dual<N>, Rows, Columns>& matrix,
                                                    std::size_t k) {
  return matrix.unaryExpr([k](const Dual<N>& x) { return x.d[k]; });
}

/// What efforts can do to the velocities that the loops allow.
struct ActuationFactors {
  MatrixX null_space;                              ///< of the closures: columns × freedoms
  SingularValueDecomposition closures, selection;  ///< the first computed only where there are closures
  bool has_closures = false;
  bool is_regular = true;  ///< the actuators hold the mechanism, and the loops keep their rank

  /// @param C closures × columns, scaled @param S actuators × columns, scaled
  ActuationFactors(const MatrixX& C, const MatrixX& S, int freedoms);
};

struct LeastNormSolution {
  VectorX efforts, multipliers;
};

/// @param f generalised forces, scaled
LeastNormSolution solve_least_norm(const ActuationFactors& factors, const MatrixX& S, const VectorX& f);

/// Its derivative with respect to one number, on which C, S and f depend; the rank of C does not change with it. With n a velocity that
/// the loops allow, u = S n, and λ = C v, the solution is that of Sᵀ S n + Cᵀ C v = f, C n = 0, which is differentiated.
LeastNormSolution differentiate_least_norm(const ActuationFactors& factors, const LeastNormSolution& solution,
                                           const MatrixX& C, const MatrixX& S, const MatrixX& dC, const MatrixX& dS,
                                           const VectorX& df);

template <class L>
class LaneActuation;

template <class S>
class Actuation : public RegularityMonitor<S> {
 public:
  using T = typename S::Scalar;

  /// @param freedoms by rank
  Actuation(const MechanismOf<T>& mechanism, const Tree<S>& tree, int freedoms);

  /// Actuators and freedoms do not fit in number; empty if they do.
  const std::string& mismatch() const { return mismatch_; }
  /// What a user should know: minimum-norm efforts or reactions.
  const std::vector<std::string>& notes() const { return notes_; }

  /// As many actuators as freedoms and independent closures: efforts and multipliers by one square system.
  bool is_regular() const { return regular_; }

  /// @param equations filled at the present configuration
  /// @param tau per tree coordinate
  /// @return false if the actuators do not hold the mechanism at this configuration
  bool solve(const KinematicEquations<S>& equations, const T* tau);

  /// The efforts as a matrix times tau: what solve() does to it at this configuration; values only.
  /// @param projection actuators × tree coordinates
  /// @return as solve()
  bool project(const KinematicEquations<S>& equations, MatrixX& projection);

  const std::vector<T>& efforts() const { return efforts_; }          ///< per actuator [N m or N]
  const std::vector<T>& multipliers() const { return multipliers_; }  ///< per closure row [N or N m]

  /// The matrix that decides whether the actuators hold the mechanism: the closures' passive columns where these are square, else
  /// closures and actuated coordinates together.
  double factorise(const KinematicEquations<S>& equations) override;
  void store() override;
  bool is_near_stored(double limit) override;
  double mobility(const KinematicEquations<S>& equations) const override;
  /// Actuators beyond the degrees of freedom.
  std::size_t redundant_count() const override;
  VectorX singular_values_without(std::size_t actuator, const KinematicEquations<S>& equations) const override;

 private:
  template <class L>
  friend class LaneActuation;  ///< the same over many samples at once
  using Matrix = Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic>;
  struct ActuatedCoordinate {
    ColumnId column;
    T ratio;      ///< of the actuated coordinate to the tree coordinate
    double unit;  ///< of the actuated coordinate: the characteristic length where it is a length, else 1
    std::vector<std::pair<int, T>> more;  ///< further columns with their ratios, of a sum
  };
  /// An entry of the closures among the equations and, where it is one of the passive columns', in `passive_`.
  struct ClosureEntry {
    int row;
    ColumnId column;
    int index = -1;
    int place = -1;  ///< among the equations' values
  };

  void prepare_regular(const Tree<S>& tree);
  bool solve_regular(const KinematicEquations<S>& equations, const T* tau);
  bool solve_general(const KinematicEquations<S>& equations, const T* tau);
  double factorise_passive(const KinematicEquations<S>& equations);
  void find_entry_indices(const KinematicEquations<S>& equations);
  bool project_regular(const KinematicEquations<S>& equations, MatrixX& projection);
  bool project_general(const KinematicEquations<S>& equations, MatrixX& projection) const;
  Matrix closure_jacobian(const KinematicEquations<S>& equations) const;
  Matrix actuation_selection(const KinematicEquations<S>& equations) const;
  void prepare_actuation_matrix();
  std::optional<double> sparse_mobility(const KinematicEquations<S>& equations) const;
  /// Closures, below them the selection.
  MatrixX actuation_matrix(const KinematicEquations<S>& equations) const;

  int columns_, closures_, freedoms_;
  bool regular_ = false;  ///< as many closures and actuators as coordinates, each actuator on its own
  std::vector<ActuatedCoordinate> actuated_;
  std::vector<ColumnId> passive_columns_;
  SquareSystem<T> passive_;  ///< closure rows × passive columns
  std::vector<ClosureEntry> closure_entries_;
  long factorised_ = -1;  ///< KinematicEquations::evaluation_count() where `passive_` was factorised
  const KinematicEquations<S>* factorised_equations_ = nullptr;
  std::size_t pattern_id_ = 0;  ///< KinematicEquations::pattern_id() that the places are of
  double regularity_ = 1;
  RankMonitor matrix_;             ///< closures and actuated coordinates
  BlockTriangular sparse_matrix_;  ///< the same of a large mechanism
  bool has_sparse_matrix_ = false;
  std::vector<std::vector<ClosureEntry>> motor_column_entries_;  ///< per actuator: the closures' entries in its column
  std::vector<T> efforts_, multipliers_;
  std::string mismatch_;
  std::vector<std::string> notes_;
};

extern template class Actuation<Planar>;
extern template class Actuation<Spatial>;

}  // namespace balance
