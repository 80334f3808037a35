#pragma once
/// Forces at one moment of a motion as a matrix times the parameters and a final 1, whose column holds the
/// contributions that do not depend on parameters: loads and friction.

#include "balance/mechanics/dynamics/actuation.hpp"
#include "balance/mechanics/dynamics/dynamic_parameters.hpp"
#include "balance/mechanics/dynamics/external_forces.hpp"
#include "balance/mechanics/dynamics/inertia_regressor.hpp"
#include "balance/mechanics/kinematics/motion_stepper.hpp"
#include "balance/mechanics/results/result.hpp"
#include "balance/mechanics/trajectory/motion_sample.hpp"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace balance::dynamics {

/// Generalised forces of springs in tree coordinates, and other linear functions of their wrenches, per unit of their
/// parameters (listed in mechanics/dynamics/dynamic_parameters.hpp).
template <class S>
class SpringRegressor {
 public:
  /// A linear function of wrenches on the nodes, which it may overwrite.
  using WrenchFunction = std::function<VectorX(std::vector<Wrench<S>>& wrenches)>;

  SpringRegressor(const Mechanism& mechanism, const kinematics::Tree<S>& tree, const FreeSprings& loose);

  /// Number of parameters of all springs.
  Eigen::Index count() const { return count_; }

  /// @param state poses in the world @param y tree coordinates
  /// @param torque tree coordinates × count [N m or N per unit]
  void evaluate(const kinematics::TreeState<S>& state, const double* y, Eigen::Ref<MatrixX> torque);
  /// The same for any function of the wrenches of springs between points; zero for springs in joints, which have none.
  /// @param values size of the function × count
  void evaluate(const kinematics::TreeState<S>& state, const WrenchFunction& function, Eigen::Ref<MatrixX> values);

 private:
  /// A spring of stiffness 1 between its own or unit end points.
  using UnitSpring = ExternalForces<S>;

  /// Parametrisation of a spring.
  enum class SpringKind { fixed, loose, in_joint };

  void add(const Spring& spring);
  VectorX value_of(const UnitSpring& spring, const kinematics::TreeState<S>& state, const WrenchFunction& function);
  void loose_at(std::size_t first, const kinematics::TreeState<S>& state, const WrenchFunction& function,
                Eigen::Ref<MatrixX> values);

  const kinematics::Tree<S>& tree_;
  const Mechanism& mechanism_;
  std::vector<UnitSpring> unit_springs_;
  std::vector<SpringKind> kinds_;  ///< per spring
  Eigen::Index count_ = 0;
  std::vector<Wrench<S>> wrenches_;
};

extern template class SpringRegressor<kinematics::Planar>;
extern template class SpringRegressor<kinematics::Spatial>;

/// The quantity that a figure is computed from.
struct AffineQuantity {
  enum class Kind {
    torque,
    power,
    shaking_force,
    shaking_moment,
    ground_force,
    ground_moment,
    kinetic_energy,
    joint_force,
    joint_moment
  };
  Kind kind = Kind::torque;
  std::optional<int> member = {};     ///< actuator or joint; std::nullopt: the worst of all actuators or joints
  bool is_combined = false;           ///< norm of all torques as one vector
  bool is_min_peak = false;           ///< the worst torque of the distribution of least peak
  std::optional<int> component = {};  ///< of a vector; std::nullopt: the vector itself
  std::optional<Vector3> about = {};  ///< world point of shaking and ground moments; std::nullopt: the trajectory's

  bool of_actuators() const { return kind == Kind::torque || kind == Kind::power; }
  bool of_joints() const { return kind == Kind::joint_force || kind == Kind::joint_moment; }
  /// Whether it is a force or the component of one; else an effort, a moment, a power or an energy.
  bool is_force() const {
    return kind == Kind::shaking_force || kind == Kind::ground_force || kind == Kind::joint_force;
  }
};

/// The name under which figures of a quantity are found. The least peak of all torques is a quantity of its own: of no
/// other figure is the distribution of least peak a convex function of the parameters.
/// @param name as in RunResult::metrics
std::string name_cost_quantity(const Mechanism& mechanism, Statistic figure, const std::string& name);

/// Number of parts of the quantity that are compared: the figure is that of the worst one.
std::size_t count_parts(const Mechanism& mechanism, const AffineQuantity& quantity, int freedoms);

/// @param name as in RunResult::metrics, or as name_cost_quantity
/// @return std::nullopt if the mechanism has no such quantity or it is not linear in the parameters
std::optional<AffineQuantity> find_affine_quantity(const Mechanism& mechanism, const std::string& name);

/// Names of the scalars that the rows of ForceRegressor::evaluate() stand for: "shaking_force[x]", "torque[A]",
/// "joint_force[B][x]".
/// @param name of the quantity, as in find_affine_quantity()
std::vector<std::string> list_row_names(const Mechanism& mechanism, const AffineQuantity& quantity,
                                        const std::string& name);

template <class S>
class ForceRegressor {
 public:
  /// @param mechanism, tree must outlive this object
  ForceRegressor(const Mechanism& mechanism, const kinematics::Tree<S>& tree, int freedoms, const Vector3& about,
                 const FreeSprings& loose);
  ForceRegressor(const ForceRegressor&) = delete;
  ForceRegressor& operator=(const ForceRegressor&) = delete;

  /// Number of parameters of mass elements and springs, plus one for the constant.
  Eigen::Index columns() const { return inertial_ + springs_.count() + 1; }
  Eigen::Index inertial() const { return inertial_; }

  /// @param stepper with poses and angular velocities, and for the kinetic energy also velocities of the origins;
  /// accelerations are overwritten
  /// @param rows one per actuator or component × columns() [SI]
  /// For several actuators or joints, their rows follow each other.
  /// @return false if the actuators cannot hold the mechanism
  bool evaluate(kinematics::MotionStepper<S>& stepper, const AffineQuantity& quantity, MatrixX& rows);

 private:
  bool evaluate_vector(kinematics::MotionStepper<S>& stepper, const AffineQuantity& quantity, MatrixX& rows);
  InertiaRegressor<S> compute_regressor(kinematics::MotionStepper<S>& stepper, const typename S::Vector& base) const;
  bool torque(kinematics::MotionStepper<S>& stepper, const AffineQuantity& quantity, MatrixX& rows);
  MatrixX min_peak_combinations() const;
  void evaluate_generalised_forces(kinematics::MotionStepper<S>& stepper);
  Wrench<S> set_known_wrenches(kinematics::MotionStepper<S>& stepper);
  void constant_torque(kinematics::MotionStepper<S>& stepper, Eigen::Ref<VectorX> tau);
  bool joint_reaction(kinematics::MotionStepper<S>& stepper, const AffineQuantity& quantity, MatrixX& rows);
  MatrixX multiplier_reactions(kinematics::MotionStepper<S>& stepper, const AffineQuantity& quantity);
  VectorX read_reactions(const kinematics::TreeState<S>& state, const AffineQuantity& quantity,
                         std::vector<Wrench<S>>& wrenches);
  void shift_moment_point(const AffineQuantity& quantity, const MatrixX& force, MatrixX& moment) const;
  void ground_reaction(kinematics::MotionStepper<S>& stepper, const AffineQuantity& quantity, MatrixX& rows);
  void kinetic_energy(const kinematics::TreeState<S>& state, MatrixX& rows) const;

  const Mechanism& mechanism_;
  const kinematics::Tree<S>& tree_;
  typename S::Vector gravity_, about_;
  Eigen::Index inertial_;
  int freedoms_;
  Mechanism known_forces_mechanism_;  ///< loads, dampers and springs with a table only
  Mechanism min_norm_mechanism_;      ///< without a distribution of efforts that is not linear
  ExternalForces<S> known_forces_;
  SpringRegressor<S> springs_;
  Actuation<S> actuation_;
  std::vector<Wrench<S>> wrenches_;
  MatrixX projection_, tau_;
  Sample reactions_;  ///< of the joints
};

extern template class ForceRegressor<kinematics::Planar>;
extern template class ForceRegressor<kinematics::Spatial>;

}  // namespace balance::dynamics
