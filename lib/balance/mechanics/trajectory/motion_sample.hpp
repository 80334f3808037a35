#pragma once
/// State of a moving mechanism at one time, however it was computed: along a trajectory in either formulation, or under
/// control.

#include "balance/foundation/base/types.hpp"

#include <vector>

namespace balance::trajectory {

/// SI, world axes; moments about the run's reference point unless stated otherwise. In planar mechanisms
/// vectors have z = 0 and moments are along z. Quantities that a formulation does not compute keep their initial
/// values.
template <class T>
struct SampleOf {
  using Vector = Vector3Of<T>;

  T time = 0;
  VectorXOf<T> position, velocity, acceleration;  ///< per coordinate of the mechanism; angles are continuous past ±π
  VectorXOf<T> effort, power;                     ///< per actuator
  Vector com = Vector::Zero(), com_velocity = Vector::Zero(), com_acceleration = Vector::Zero();
  Vector tool_position = Vector::Zero();  ///< zero without a tool
  Matrix3Of<T> tool_rotation = Matrix3Of<T>::Identity();
  T tool_angle = 0;                            ///< planar, continuous past ±π
  Vector shaking_force = Vector::Zero();       ///< rate of the linear momentum (P3 eq. 23)
  Vector shaking_moment = Vector::Zero();      ///< rate of the angular momentum (P3 eq. 27)
  Vector shaking_moment_com = Vector::Zero();  ///< rate of the angular momentum about the moving centre of mass
  Vector ground_force = Vector::Zero();        ///< on the frame, weight included
  Vector ground_moment = Vector::Zero();
  std::vector<Vector> joint_force;   ///< on the second body
  std::vector<Vector> joint_moment;  ///< about the joint's point on the second body
  VectorXOf<T>
      constraint_force;  ///< per constraint of the mechanism: generalised force conjugate to the constrained speed
  VectorXOf<T> constraint_power;  ///< per constraint: power of that force; zero unless the speed is not zero
  T kinetic_energy = 0, potential_energy = 0;
  T total_torque = 0;  ///< root of the sum of the squared efforts; meaningful if all have the same unit
  T mobility = 0;      ///< smallest singular value of the scaled equations that determine the motion
  int newton_iterations = 0;

  // of a mechanism driven by efforts
  T friction_power = 0;         ///< dissipated by friction, non-negative [W]
  double closure_residual = 0;  ///< largest scaled residual of the loop closures

  // of a run under control
  VectorX desired_position, tracking_error;  ///< per coordinate: desired − actual
  Vector3 desired_tool_position = Vector3::Zero(), tool_error = Vector3::Zero();  ///< desired − actual
  double tool_angle_error = 0;  ///< planar: desired − actual; spatial: angle between the two
  VectorX sliding_variable;     ///< per sliding variable
  VectorX torque_variation;     ///< per actuator: Σ |changes of the effort| so far
  VectorX saturation;           ///< per actuator: 1 while the effort is limited, else 0

  /// Fills the quantities that follow from others: total_torque, and shaking_moment_com = M − (c − o) × F.
  /// @param about reference point o of the run
  void add_derived(const Vector& about) {
    total_torque = effort.norm();
    shaking_moment_com = shaking_moment - (com - about).cross(shaking_force);
  }
};

using Sample = SampleOf<double>;

}  // namespace balance::trajectory

namespace balance {

using trajectory::Sample;

}  // namespace balance
