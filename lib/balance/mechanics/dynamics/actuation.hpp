#pragma once
/// From the tree's generalised forces to actuator efforts and loop multipliers: τ = Sᵀ u + Φᵀ λ, which is P0's
/// projection u = Cᵀ τ with C normalised on the actuated rows (P0 eq. 17, 29–34).

#include "balance/foundation/base/dual.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/overdetermined_system.hpp"
#include "balance/foundation/numerics/square_system.hpp"
#include "balance/mechanics/kinematics/kinematic_equations.hpp"
#include "balance/mechanics/model/torque_distribution.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"

#include <optional>
#include <string>
#include <vector>

namespace balance::lanes {
template <class L>
class LaneActuation;
}

namespace balance::dynamics {

// Efforts, by default of minimum norm, and for these minimum-norm multipliers, if actuators or closures are redundant:
// Sᵀ u + Cᵀ λ = f.

// ---- matrices over dual numbers ----

template <class T, int Rows, int Columns>
Eigen::Matrix<double, Rows, Columns> values_of(const Eigen::Matrix<T, Rows, Columns>& matrix) {
  return matrix.unaryExpr([](const T& x) { return value_of(x); });
}

/// Derivatives with respect to variable k.
template <int N, int Rows, int Columns>
Eigen::Matrix<double, Rows, Columns> derivatives_of(const Eigen::Matrix<Dual<N>, Rows, Columns>& matrix,
                                                    std::size_t k) {
  return matrix.unaryExpr([k](const Dual<N>& x) { return x.d[k]; });
}

/// Factors of the map from efforts to the velocities that the loops allow.
struct ActuationFactors {
  MatrixX null_space;                                        ///< of the closures: columns × freedoms
  numerics::SingularValueDecomposition closures, selection;  ///< the first is computed only if there are closures
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

/// The multipliers of minimum norm for given efforts.
VectorX solve_multipliers(const ActuationFactors& factors, const MatrixX& S, const VectorX& f, const VectorX& efforts);

/// An equation that efforts meet besides Sᵀ u + Cᵀ λ = f, with its derivative with respect to one variable:
/// u[actuator] = bound + excess_share · excess + peak_share · peak.
struct ActiveBoundChange {
  Eigen::Index actuator = 0;
  double excess_share = 0, peak_share = 0;  ///< 0: excess or peak do not occur
  double bound_change = 0, excess_share_change = 0;
};

/// The solution's derivative with respect to one variable, on which C, S and f depend while the rank of C is constant.
/// With u = S n + Eᵀ μ, n a velocity that the loops allow, and λ = C v, the efforts of minimum norm that meet the active
/// bounds E u = g + q e + p t solve, with these, Sᵀ u + Cᵀ C v = f, C n = 0, qᵀ μ = 0 and pᵀ μ = 0, which is
/// differentiated. The excess e and the peak t are unknowns.
/// @param excess e
LeastNormSolution differentiate_least_norm(const ActuationFactors& factors, const LeastNormSolution& solution,
                                           const MatrixX& C, const MatrixX& S, const MatrixX& dC, const MatrixX& dS,
                                           const VectorX& df, const std::vector<ActiveBoundChange>& active = {},
                                           double excess = 0);

template <class S>
class Actuation : public kinematics::RegularityMonitor<S> {
 public:
  using T = typename S::Scalar;

  /// @param freedoms computed by rank
  Actuation(const MechanismOf<T>& mechanism, const kinematics::Tree<S>& tree, int freedoms);

  /// Message if there are too few actuators for the freedoms; else empty.
  const std::string& mismatch() const { return mismatch_; }
  /// Notes for the user: how efforts are distributed; minimum-norm reactions.
  const std::vector<std::string>& notes() const { return notes_; }

  /// Whether there are as many actuators as freedoms, and independent closures, so that one square system yields
  /// efforts and multipliers.
  bool is_regular() const { return regular_; }

  /// @param equations evaluated at the present configuration
  /// @param tau per tree coordinate
  /// @return false if the actuators do not hold the mechanism at this configuration
  bool solve(const kinematics::KinematicEquations<S>& equations, const T* tau);

  /// The matrix by which solve() maps tau to the efforts at this configuration; values only.
  /// @param projection actuators × tree coordinates
  /// @return as solve()
  /// @throws std::invalid_argument if the efforts are not a linear function: see has_linear_projection()
  bool project(const kinematics::KinematicEquations<S>& equations, MatrixX& projection);

  /// Whether the efforts are a linear function of tau: no redundant actuators, or least norm without bounds.
  bool has_linear_projection() const { return !distribution_ || distribution_->is_linear; }

  const std::vector<T>& efforts() const { return efforts_; }          ///< per actuator [N m or N]
  const std::vector<T>& multipliers() const { return multipliers_; }  ///< per closure row [N or N m]

  /// Factorises the matrix that decides whether the actuators hold the mechanism: the closures' passive columns if
  /// these are square, else closures and actuated coordinates together.
  double factorise(const kinematics::KinematicEquations<S>& equations) override;
  void store() override;
  bool is_near_stored(double limit) override;
  double mobility(const kinematics::KinematicEquations<S>& equations) const override;
  /// Number of actuators, if there are more than degrees of freedom and the mechanism has loops; else 0.
  std::size_t redundant_count() const override;
  VectorX singular_values_without(std::size_t actuator,
                                  const kinematics::KinematicEquations<S>& equations) const override;

 private:
  template <class L>
  friend class lanes::LaneActuation;  ///< the same for many samples at once
  using Matrix = Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic>;
  struct ActuatedCoordinate {
    kinematics::ColumnId column;
    T ratio;      ///< of the actuated coordinate to the tree coordinate
    double unit;  ///< of the actuated coordinate: the characteristic length where it is a length, else 1
    std::vector<std::pair<int, T>> further_terms;  ///< further columns and ratios of a sum
  };
  /// An entry of the closures, and its indices among the equations' values and, for passive columns, in `passive_`.
  struct ClosureEntry {
    int row;
    kinematics::ColumnId column;
    int index = -1;
    int storage_index = -1;  ///< storage index among the equations' values
  };

  void prepare_regular(const kinematics::Tree<S>& tree);
  bool solve_regular(const kinematics::KinematicEquations<S>& equations, const T* tau);
  bool solve_general(const kinematics::KinematicEquations<S>& equations, const T* tau);
  double factorise_passive(const kinematics::KinematicEquations<S>& equations);
  void find_entry_indices(const kinematics::KinematicEquations<S>& equations);
  bool project_regular(const kinematics::KinematicEquations<S>& equations, MatrixX& projection);
  bool project_general(const kinematics::KinematicEquations<S>& equations, MatrixX& projection) const;
  Matrix closure_jacobian(const kinematics::KinematicEquations<S>& equations) const;
  Matrix actuation_selection(const kinematics::KinematicEquations<S>& equations) const;
  void scale_selection(Matrix& selection) const;
  ActiveBoundChange bound_change(const numerics::ActiveBound& bound, std::size_t k) const;
  void prepare_actuation_matrix();
  std::optional<double> sparse_mobility(const kinematics::KinematicEquations<S>& equations) const;
  /// The closures, and below them the selection.
  MatrixX actuation_matrix(const kinematics::KinematicEquations<S>& equations) const;

  int columns_, closures_, freedoms_;
  bool regular_ = false;  ///< as many closures and actuators as coordinates, each actuator on a column of its own
  std::vector<ActuatedCoordinate> actuated_;
  std::vector<kinematics::ColumnId> passive_columns_;
  numerics::SquareSystem<T> passive_;  ///< closure rows × passive columns
  std::vector<ClosureEntry> closure_entries_;
  long factorised_evaluation_ = -1;  ///< KinematicEquations::evaluation_count() when `passive_` was factorised
  const kinematics::KinematicEquations<S>* factorised_equations_ = nullptr;
  std::size_t pattern_id_ = 0;  ///< KinematicEquations::pattern_id() of the storage indices
  double regularity_ = 1;
  numerics::RankMonitor matrix_;             ///< closures and actuated coordinates
  numerics::BlockTriangular sparse_matrix_;  ///< the same for a large mechanism
  bool has_sparse_matrix_ = false;
  std::vector<std::vector<ClosureEntry>> motor_column_entries_;  ///< per actuator: the closures' entries in its column
  std::vector<T> efforts_, multipliers_;
  std::optional<model::ScaledDistribution<T>> distribution_;  ///< of redundant actuators; none: least norm
  std::string mismatch_;
  std::vector<std::string> notes_;
};

extern template class Actuation<kinematics::Planar>;
extern template class Actuation<kinematics::Spatial>;

}  // namespace balance::dynamics
