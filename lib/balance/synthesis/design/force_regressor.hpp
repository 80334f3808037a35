#pragma once
/// Forces at one moment of a motion as a matrix times the parameters and a one behind them, which carries what does not depend
/// on any parameter: loads and friction.

#include "balance/mechanics/dynamics/actuation.hpp"
#include "balance/mechanics/dynamics/dynamic_parameters.hpp"
#include "balance/mechanics/dynamics/external_forces.hpp"
#include "balance/mechanics/dynamics/inertia_regressor.hpp"
#include "balance/mechanics/kinematics/motion_stepper.hpp"

#include <optional>
#include <string>
#include <vector>

namespace balance {

/// What springs ask of the tree's coordinates, per unit of their parameters (mechanics/dynamics/dynamic_parameters.hpp lists these).
template <class S>
class SpringRegressor {
 public:
  SpringRegressor(const Mechanism& mechanism, const Tree<S>& tree, const FreeSprings& loose);

  /// Parameters of all springs.
  Eigen::Index count() const { return count_; }

  /// @param state poses in the world @param y tree coordinates
  /// @param torque tree coordinates × count [N m or N per unit]
  void evaluate(const TreeState<S>& state, const double* y, Eigen::Ref<MatrixX> torque);

 private:
  /// A spring of stiffness 1, at rest or between unit points.
  using UnitSpring = ExternalForces<S>;

  /// How a spring's parameters are counted.
  enum class SpringKind { fixed, loose, in_joint };

  void add(const Spring& spring);
  VectorX torque_of(const UnitSpring& spring, const TreeState<S>& state);
  void loose_at(std::size_t first, const TreeState<S>& state, Eigen::Ref<MatrixX> torque);

  const Tree<S>& tree_;
  const Mechanism& mechanism_;
  std::vector<UnitSpring> units_;
  std::vector<SpringKind> forms_;  ///< per spring
  Eigen::Index count_ = 0;
  std::vector<Wrench<S>> wrenches_;
};

extern template class SpringRegressor<Planar>;
extern template class SpringRegressor<Spatial>;

/// What a figure is of.
struct CostQuantity {
  enum class Kind { torque, power, shaking_force, shaking_moment, ground_force, ground_moment, kinetic_energy };
  Kind kind = Kind::torque;
  std::optional<int> actuator;  ///< torque, power: of this one; nothing: of each, and the worst counts
  bool is_combined = false;     ///< of all torques as one vector

  bool of_actuators() const { return kind == Kind::torque || kind == Kind::power; }
};

/// @param name as in RunResult::metrics
/// @return nothing if the mechanism has no such quantity, or it is not linear in the parameters
std::optional<CostQuantity> find_cost_quantity(const Mechanism& mechanism, const std::string& name);

template <class S>
class ForceRegressor {
 public:
  /// @param mechanism, tree must outlive the matrices
  ForceRegressor(const Mechanism& mechanism, const Tree<S>& tree, int freedoms, const Vector3& about,
                 const FreeSprings& loose);
  ForceRegressor(const ForceRegressor&) = delete;
  ForceRegressor& operator=(const ForceRegressor&) = delete;

  /// Parameters of elements and springs, and the one behind them.
  Eigen::Index columns() const { return inertial_ + springs_.count() + 1; }
  Eigen::Index inertial() const { return inertial_; }

  /// @param stepper its state holds poses and angular velocities, for the kinetic energy also the origins' velocities;
  ///        accelerations are overwritten
  /// @param rows one per actuator or component × columns() [SI]
  /// @return false if the actuators do not hold the mechanism
  bool evaluate(MotionStepper<S>& stepper, const CostQuantity& quantity, MatrixX& rows);

 private:
  InertiaRegressor<S> compute_regressor(MotionStepper<S>& stepper, const typename S::Vector& base) const;
  bool torque(MotionStepper<S>& stepper, const CostQuantity& quantity, MatrixX& rows);
  void constant_torque(MotionStepper<S>& stepper, Eigen::Ref<VectorX> tau);
  void shift_moment_point(const MatrixX& force, MatrixX& moment) const;
  void ground_reaction(MotionStepper<S>& stepper, bool moment, MatrixX& rows);
  void kinetic_energy(const TreeState<S>& state, MatrixX& rows) const;

  const Mechanism& mechanism_;
  const Tree<S>& tree_;
  typename S::Vector gravity_, about_;
  Eigen::Index inertial_;
  Mechanism loaded_;  ///< the loads alone
  ExternalForces<S> loads_;
  SpringRegressor<S> springs_;
  Actuation<S> actuation_;
  std::vector<Wrench<S>> wrenches_;
  MatrixX projection_, tau_;
};

extern template class ForceRegressor<Planar>;
extern template class ForceRegressor<Spatial>;

}  // namespace balance
