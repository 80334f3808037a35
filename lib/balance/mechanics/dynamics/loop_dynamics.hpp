#pragma once
/// Forward dynamics in tree coordinates with the loops solved for: the core of ForwardDynamics and Plant.

#include "balance/mechanics/dynamics/external_forces.hpp"
#include "balance/mechanics/dynamics/forward_dynamics.hpp"
#include "balance/mechanics/dynamics/stiction.hpp"
#include "balance/mechanics/dynamics/tree_dynamics.hpp"
#include "balance/mechanics/kinematics/kinematic_equations.hpp"

#include <optional>

namespace balance::dynamics {

template <class S>
class LoopDynamics {
 public:
  LoopDynamics(const Mechanism& mechanism, const ForwardOptions& options);

  /// The tree with all closures. Only the reference orientations of its spherical joints ever change.
  const kinematics::Tree<S>& tree() const { return full_tree_; }
  int columns() const { return full_tree_.columns; }
  int freedoms() const { return freedoms_; }                        ///< −1 before assemble()
  const std::vector<int>& independent() const { return columns_; }  ///< tree columns
  const std::vector<double>& scale() const { return scale_; }       ///< per tree column: 1 or the characteristic length
  bool has_redundant_closures() const { return full_tree_.closure_rows > columns() - freedoms_; }

  /// Converts joint coordinates to tree coordinates that close the loops. Chooses independent columns, the preferred
  /// ones if possible, which keep the values given by q and dq.
  MotionOutcome assemble(double time, const VectorX& q, const VectorX& dq, VectorX& y, VectorX& dy);

  /// Chooses independent columns at a closed configuration. solve_dependent() must follow.
  /// @param prefer take the preferred ones if they determine the others
  /// @return false at a singularity of the closures
  bool choose_independent_columns(const double* y, bool prefer);
  int choice_count() const { return choice_count_; }
  /// Smallest over largest pivot of the closures at the last choice; 1 without loops.
  double closure_regularity() const { return closure_regularity_; }

  /// Solves for the dependent entries of y by Newton's method, then for the dependent rates. Updates the poses.
  /// @param time at which constraints on speeds take their values
  /// @return false if there is no solution nearby
  bool solve_dependent(double time, double* y, double* dy);

  /// Accelerations at the state of the last solve_dependent().
  /// @return false if the mass matrix is not positive definite or the accelerations are not finite
  bool accelerate(double time, const double* dy, const double* efforts, double* ddy);

  // Its parts at that state, after compute_tree_terms():
  void compute_tree_terms(double time, const double* dy);
  const std::vector<double>& mass() const { return mass_; }                 ///< n×n
  const std::vector<double>& bias() const { return tau_; }                  ///< n, in tree coordinates with ÿ = 0
  const std::vector<double>& transformation() const { return C_; }          ///< n×d, row by row
  const std::vector<double>& transformation_bias() const { return ddy0_; }  ///< n
  /// Computes M (d×d) and Cᵀ(H c + bias), which the next two functions return.
  void reduce_to_independent();
  const MatrixX& reduced_mass() const { return M_; }
  const VectorX& reduced_bias() const { return bias_; }

  /// Multipliers per row of all closures, minimum norm if they are not unique.
  /// @param ddy as computed by accelerate()
  void multipliers(const double* efforts, const double* ddy, const double* y, std::vector<double>& out);

  kinematics::TreeState<S>& state() { return state_; }
  const kinematics::KinematicEquations<S>& equations() const { return *equations_; }
  bool is_open_tree() const { return full_tree_.closures.empty(); }
  int iterations() const { return iterations_; }
  /// Smallest pivot now, and when the independent columns were chosen; 1 without loops.
  double regularity() const { return is_open_tree() ? 1 : equations_->regularity(); }
  double regularity_at_choice() const { return regularity_at_choice_; }
  /// Stores the matrix last factorised, for the present choice of independent columns: see
  /// KinematicEquations::is_near_stored.
  void store() { is_open_tree() ? void() : equations_->store(); }
  bool near_kept(double limit) { return is_open_tree() || equations_->is_near_stored(limit); }
  /// Largest scaled residual of all closures at the poses of state().
  double residual() const;
  double mobility();

  // Dry friction (stiction.cpp). A sticking joint holds its column at rest, which is chosen to be independent if
  // possible:
  const std::vector<JointFriction>& frictions() const { return frictions_; }
  bool has_dry_friction() const { return has_dry_friction_; }
  bool is_any_sticking() const { return !sticking_.empty(); }
  bool has_shared_stiction() const {
    return held_count_ < sticking_.size();
  }  ///< sticking joints depend on each other: their friction is not unique
  /// Decides at the state last solved which joints at rest stick, and in which direction all others slip.
  /// @param dy on return exactly 0 for joints that stick
  /// @param rest_threshold rates up to this, or of the wrong sign, count as rest [rad/s, or characteristic lengths per
  ///        second]
  /// @return what changed; after sticking_set, choose_independent_columns() must follow
  FrictionChange decide_friction(double time, double* dy, const double* efforts, double rest_threshold);
  /// Margin to the next change at the state last solved: negative if some joint has come to rest or broken loose since
  /// the last decision.
  /// @param reference_rate rate that serves as unit for the margin of rates, in the same units as `rest_threshold`
  double friction_margin(double time, const double* dy, const double* efforts, double reference_rate);
  /// Adds the friction of sticking joints to bias(). To be called after accelerate(), which does not need it.
  void add_sticking_friction(const double* efforts, const double* ddy);
  double friction_power(const double* dy) const;

  /// Resets the reference of every spherical joint whose middle angle is beyond the limit [rad]; solve_dependent() must
  /// follow.
  /// @return whether any was reset
  bool reset_spherical_references(double limit, double* y, double* dy);

 private:
  /// A column that an actuator loads with ratio times its effort.
  struct ActuatedColumn {
    std::size_t actuator;
    int column;
    double ratio;
  };
  void set_coordinates(const double* y);
  void dependent_poses(const double* y);
  void apply_second_order_correction(double* y);
  void set_unit_rate_rhs(int k, std::vector<double>& rows) const;
  void store_transformation_column(int k, const std::vector<double>& rates);
  void add_friction(const double* dy);
  double friction_force(const JointFriction& joint, double rate) const;
  StickProblem stick_problem(const double* efforts, const std::vector<int>& at_rest);
  StickSolution solve_stiction_at(double time, const double* dy, const double* efforts,
                                  const std::vector<int>& at_rest);
  void reset_friction();
  std::vector<bool> sticking_columns() const;
  void mark_sticking_columns();
  void fix_sticking_accelerations();
  void weigh_columns();
  void select_closure_rows(const std::vector<int>& rows);
  std::vector<int> preferred_columns() const;
  std::vector<int> select_preferred(const std::vector<int>& preferred, const MatrixX& jacobian) const;

  const Mechanism& mechanism_;
  ForwardOptions options_;
  kinematics::Tree<S> full_tree_, tree_;         ///< tree_: with independent closure rows only, as many as the rank
  std::vector<typename S::Rotation> reference_;  ///< of every spherical joint, as compiled
  std::vector<double> scale_, column_weight_;
  kinematics::Drive<S> drive_;  ///< prescribes the independent columns
  std::optional<kinematics::KinematicEquations<S>> equations_;
  ExternalForces<S> external_;
  std::vector<double> y_;              ///< the tree coordinates last solved
  std::vector<double> joint_springs_;  ///< the generalised forces of the springs there
  CompositeRigidBodies<S> composite_;
  typename S::Vector gravity_;
  double ground_extent_;  ///< of the ground, in characteristic lengths
  int freedoms_ = -1, iterations_ = 0, choice_count_ = 0;
  double regularity_at_choice_ = 1, closure_regularity_ = 1;
  std::vector<int> columns_;
  std::vector<bool> is_dependent_node_;  ///< per node: its column is not independent
  std::vector<ActuatedColumn> actuated_columns_;
  std::vector<JointFriction> frictions_;
  bool has_dry_friction_ = false;
  std::vector<int> sticking_, at_rest_, new_stuck_;  ///< indices into frictions_; the last two are scratch
  std::vector<bool> is_sticking_column_;             ///< per independent column: held by a sticking joint
  std::size_t held_count_ = 0;
  kinematics::TreeState<S> state_;
  trajectory::DriveSample sample_;
  std::vector<Wrench<S>> wrenches_;
  std::vector<double> x_, rates_, mass_, tau_, C_, ddy0_, HC_, factor_, rhs_;
  MatrixX M_;
  VectorX bias_;
};

extern template class LoopDynamics<kinematics::Planar>;
extern template class LoopDynamics<kinematics::Spatial>;

// Freedoms without inertia: bodies without mass or without extent may leave the mass matrix singular.

/// @param loops assembled and solved; its terms may be recomputed
/// @return done, or which coordinate moves without inertia and which body lacks it
template <class S>
MotionOutcome check_mass_matrix(const Mechanism& mechanism, LoopDynamics<S>& loops, double time, const double* dy);

}  // namespace balance::dynamics
