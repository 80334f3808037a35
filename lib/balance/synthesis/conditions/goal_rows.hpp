#pragma once
/// The quantities that a goal requires to vanish, at one configuration, per unit of every parameter.
///
/// Everything is in the mechanism's natural units, so that all entries are comparable: lengths in characteristic
/// lengths L, accelerations in units of gravity (1 m/s² without gravity). The unknowns are the parameters in their
/// natural units.

#include "balance/mechanics/dynamics/inertia_regressor.hpp"
#include "balance/mechanics/kinematics/forward_kinematics.hpp"
#include "balance/synthesis/conditions/conditions.hpp"
#include "balance/synthesis/conditions/configuration_sampler.hpp"
#include "balance/synthesis/conditions/known_terms.hpp"

#include <array>
#include <string>
#include <vector>

namespace balance::conditions {

// Generalised forces that loads, friction, dampers and springs with a table require at the tree's coordinates, per unit of each known term.

/// Changes of all loads' components (columns) since each load's first time, at all times of all tables (rows).
MatrixX load_histories(const Mechanism& mechanism);
/// Column of a load's term in load_histories and load_changes.
Eigen::Index load_component(const dynamics::Parameter& term, bool planar);

template <class S>
class KnownTermColumns {
 public:
  /// @param mechanism, tree must outlive the columns
  KnownTermColumns(const Mechanism& mechanism, const kinematics::Tree<S>& tree);

  Eigen::Index size() const { return static_cast<Eigen::Index>(terms_.size()); }
  bool has_static_terms() const { return !mechanism_.loads.empty() || has_tables_; }
  bool has_changes() const { return changes_.size() > 0; }
  bool has_friction() const { return !mechanism_.friction.empty() || has_dampers_; }

  /// Columns of the loads' initial values, of loads over a coordinate and of tables and, separately, of the
  /// loads' changes over time; overwrites the
  /// velocities in `state`.
  /// @param y tree coordinates of the state
  void static_columns(const VectorX& y, kinematics::TreeState<S>& state, MatrixX& constant, MatrixX& changing) const;
  /// Overwrites the velocities in `state`. @param dy rates of the tree's coordinates
  MatrixX friction_columns(const VectorX& dy, kinematics::TreeState<S>& state) const;

 private:
  MatrixX displacement_gradients(kinematics::TreeState<S>& state) const;
  double table_force(std::size_t index, const VectorX& y, const kinematics::TreeState<S>& state) const;
  MatrixX load_torques(kinematics::TreeState<S>& state) const;

  const Mechanism& mechanism_;
  const kinematics::Tree<S>& tree_;
  std::vector<dynamics::Parameter> terms_;
  std::vector<model::LoadTable<double>> tables_;  ///< per load
  std::vector<model::ForceLawOf<double>> laws_;   ///< per force element; empty of a damper
  MatrixX changes_;                               ///< load_changes, if any load changes
  bool has_tables_ = false, has_dampers_ = false;
};

extern template class KnownTermColumns<kinematics::Planar>;
extern template class KnownTermColumns<kinematics::Spatial>;

/// The mechanism's natural units, in SI.
struct NaturalUnits {
  double length = 1, acceleration = 1, mass = 1;
  VectorX parameter;  ///< per parameter: π = unit · π̂, with π̂ in kg

  /// @param parameters may include known terms
  NaturalUnits(const Mechanism& mechanism, const std::vector<dynamics::Parameter>& parameters);
};

/// Velocities for which the rows of one sample are evaluated; scaled as in SampledConfiguration.
struct VelocityProbe {
  MatrixX directions;  ///< columns × k: spans the admissible velocities
  VectorX velocity;    ///< an admissible velocity
};

/// Components of the momenta, or of their rates, that goals require to vanish.
struct MomentumComponents {
  bool is_at_constant_speed = false;        ///< rates, while the held coordinates have constant speeds
  std::vector<CoordinateId> coordinates;    ///< at constant speed
  MatrixX held_rows;                        ///< directions of their rates over scaled rates of the tree's coordinates
  std::string about;                        ///< reference point of the angular momentum; empty: of the options
  std::array<bool, 3> linear{}, angular{};  ///< along the ground's axes

  void add(const Goal& goal);
};

template <class S>
class GoalRows {
 public:
  /// @param tree, units must outlive the rows; units of all terms, including known ones
  GoalRows(const Mechanism& mechanism, const kinematics::Tree<S>& tree, const NaturalUnits& units,
           std::vector<Goal> goals, const ConditionOptions& options, int freedoms);

  /// Why the goals do not apply to this mechanism; empty if they do.
  const std::string& mismatch_reason() const { return mismatch_; }
  /// Whether a goal takes speeds of coordinates as constant.
  bool has_constant_speeds() const;
  /// Number of columns of terms, including known ones.
  int parameters() const { return parameters_; }
  /// Number of unknowns after the parameters: the matrices of the goals `proportional` (A) and `affine` (A, then B)
  /// [kg].
  int extra_unknowns() const { return extra_count_; }
  /// Per term: 1, or 0 if it is left out or absent.
  const VectorX& term_mask() const { return term_mask_; }

  /// @param rows rows × (parameters + extra). Rows of goals named `fully-…` are differences from the first configuration
  /// evaluated, where they are zero.
  /// @return false, without rows, if the actuators do not hold the mechanism well there
  bool evaluate(const SampledConfiguration& configuration, const VelocityProbe& probe, MatrixX& rows);

 private:
  void check_goals(int freedoms);
  bool has_goal(GoalKind kind) const;
  void list_momentum_components();
  void check_constant_speeds(int freedoms);
  MatrixX coordinate_rows(const std::vector<CoordinateId>& coordinates) const;
  bool set_actuated(const MatrixX& null_space);
  bool set_speeds(const MatrixX& null_space);
  /// Speeds per scaled rate of the tree's coordinates, in natural units.
  MatrixX speed_rows();
  /// The part of the speeds' derivatives that is due to a velocity, in natural units.
  VectorX speed_products(const VectorX& dy);
  VectorX held_bias(const VectorX& velocity, const MatrixX& held_rows, bool holds_speeds);
  void set_motion(const VectorX& velocity, const VectorX& acceleration, bool weight);
  dynamics::InertiaRegressor<S> compute_regressor(const VectorX& velocity, const VectorX& acceleration, bool weight);
  void append_rows(const MatrixX& rows, double unit);
  void append_known_rows(const MatrixX& projection, const MatrixX& torque, double unit);
  void mask_excluded_terms();
  void add_efforts(const VelocityProbe& probe);
  void add_static_efforts(const MatrixX& projection);
  void add_inertia();
  void add_momentum(const VelocityProbe& probe);
  void add_momentum_rates(const VelocityProbe& probe, const MatrixX& null_space);
  void append_momentum(const dynamics::InertiaRegressor<S>& momentum, const MomentumComponents& components);
  void append_com_tool_rows(const MatrixX& momentum);
  MatrixX spring_torques();

  const Mechanism& mechanism_;
  const kinematics::Tree<S>& tree_;
  const NaturalUnits& units_;
  std::vector<Goal> goals_;
  ConditionOptions options_;
  std::string mismatch_;
  bool needs_actuators_ = false, is_fully_ = false;
  std::vector<MomentumComponents> momentum_components_;
  int parameters_ = 0, inertial_count_ = 0, extra_count_ = 0;
  VectorX scale_;
  KnownTermColumns<S> known_terms_;
  VectorX term_mask_;  ///< per term: 1, or 0 if it is left out or absent
  kinematics::FixedFrame<S> tool_;
  MatrixX selection_;  ///< actuated × columns, scaled
  MatrixX actuated_;   ///< columns × actuated: C, whose actuated rows are the identity
  std::vector<model::GeneralisedSpeed> speeds_;
  VectorX speed_units_;
  std::vector<int> independent_speeds_;  ///< those that determine the motion at the first configuration
  MatrixX speed_rows_;                   ///< of the independent speeds × columns, scaled
  MatrixX speed_directions_;             ///< columns × independent speeds: scaled rates per speed
  MatrixX inertia_reference_;
  kinematics::TreeState<S> state_;
  VectorX y_;
  MatrixX out_;
  Eigen::Index row_count_ = 0;
};

extern template class GoalRows<kinematics::Planar>;
extern template class GoalRows<kinematics::Spatial>;

}  // namespace balance::conditions
