#pragma once
/// What a goal wants to vanish, at one configuration, per unit of every parameter.
///
/// Everything is in the mechanism's own units, so that all entries are comparable numbers: lengths in characteristic lengths L,
/// accelerations in units of gravity (of 1 m/s² without it). Unknowns are the parameters in their natural units.

#include "balance/mechanics/dynamics/inertia_regressor.hpp"
#include "balance/mechanics/kinematics/forward_kinematics.hpp"
#include "balance/synthesis/conditions/conditions.hpp"
#include "balance/synthesis/conditions/configuration_sampler.hpp"
#include "balance/synthesis/conditions/known_terms.hpp"

namespace balance {

// What loads and friction ask of the tree's coordinates, per unit of each known term.

/// Changes since the first times of all loads' components (columns) at all times of all tables (rows); nothing without tables.
MatrixX load_histories(const Mechanism& mechanism);
/// Column of a load's term there and in load_changes.
Eigen::Index load_component(const Parameter& term, bool planar);

template <class S>
class KnownTermColumns {
 public:
  /// @param mechanism, tree must outlive the columns
  KnownTermColumns(const Mechanism& mechanism, const Tree<S>& tree);

  Eigen::Index size() const { return static_cast<Eigen::Index>(terms_.size()); }
  bool has_loads() const { return !mechanism_.loads.empty(); }
  bool has_changes() const { return changes_.size() > 0; }
  bool has_friction() const { return !mechanism_.friction.empty(); }

  /// Columns of the loads as they are at first and, apart from these, of their changes; velocities in `state` are overwritten.
  void load_columns(TreeState<S>& state, MatrixX& constant, MatrixX& changing) const;
  /// @param dy rates of the tree's coordinates
  MatrixX friction_columns(const VectorX& dy) const;

 private:
  MatrixX load_torques(TreeState<S>& state) const;

  const Mechanism& mechanism_;
  const Tree<S>& tree_;
  std::vector<Parameter> terms_;
  MatrixX changes_;  ///< load_changes, where there are any
};

extern template class KnownTermColumns<Planar>;
extern template class KnownTermColumns<Spatial>;

/// The mechanism's own units, in SI.
struct NaturalUnits {
  double length = 1, acceleration = 1, mass = 1;
  VectorX parameter;  ///< per parameter: π = unit · π̂, with π̂ in kg

  /// @param parameters known terms may be among them
  NaturalUnits(const Mechanism& mechanism, const std::vector<Parameter>& parameters);
};

/// Which velocities and accelerations the rows of one sample are taken for; all scaled like Configuration's.
struct VelocityProbe {
  MatrixX directions;  ///< columns × k: spans the velocities that the loops allow
  VectorX velocity;    ///< one of them
};

template <class S>
class GoalRows {
 public:
  /// @param tree, units must outlive the rows; units of all terms, known ones included
  GoalRows(const Mechanism& mechanism, const Tree<S>& tree, const NaturalUnits& units, std::vector<Goal> goals,
           const ConditionOptions& options, int freedoms);

  /// Why the goals make no sense for this mechanism; empty if they do.
  const std::string& mismatch_reason() const { return mismatch_; }
  /// Columns of terms, known ones included.
  int parameters() const { return parameters_; }
  /// Unknowns that are no parameters, behind them: the matrices of the goals `proportional` (A) and `affine` (A, then B) [kg].
  int extra_unknowns() const { return extra_; }

  /// @param rows rows × (parameters + extra). Those of fully- goals are differences from the first configuration probed, where
  ///        they are zero.
  /// @return false, and no rows, if the actuators do not hold the mechanism well there
  bool evaluate(const SampledConfiguration& configuration, const VelocityProbe& probe, MatrixX& rows);

 private:
  void check_goals(int freedoms);
  bool has_goal(GoalKind kind) const;
  bool set_configuration(const SampledConfiguration& configuration);
  bool set_actuated(const MatrixX& null_space);
  VectorX actuated_bias(const VectorX& velocity);
  void set_motion(const VectorX& velocity, const VectorX& acceleration, bool weight);
  InertiaRegressor<S> compute_regressor(const VectorX& velocity, const VectorX& acceleration, bool weight);
  void append_rows(const MatrixX& rows, double unit);
  void append_known_rows(const MatrixX& projection, const MatrixX& torque, double unit);
  void mask_excluded_terms();
  void add_efforts(const VelocityProbe& probe);
  void add_static_efforts(const MatrixX& projection);
  void add_inertia();
  void add_momentum(const VelocityProbe& probe);
  void append_com_tool_rows(const MatrixX& momentum);
  MatrixX spring_torques();

  const Mechanism& mechanism_;
  const Tree<S>& tree_;
  const NaturalUnits& units_;
  std::vector<Goal> goals_;
  ConditionOptions options_;
  std::string mismatch_;
  bool needs_actuators_ = false, is_fully_ = false;
  int parameters_ = 0, inertial_ = 0, extra_ = 0;
  VectorX scale_;
  KnownTermColumns<S> known_;
  VectorX term_mask_;  ///< per term: 1, or 0 for what is left out or not there
  FixedFrame<S> tool_;
  MatrixX selection_;  ///< actuated × columns, scaled
  MatrixX actuated_;   ///< columns × actuated: C, whose actuated rows are the identity
  MatrixX inertia_reference_;
  TreeState<S> state_;
  VectorX y_;
  MatrixX out_;
  Eigen::Index filled_ = 0;
};

extern template class GoalRows<Planar>;
extern template class GoalRows<Spatial>;

}  // namespace balance
