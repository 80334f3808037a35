#pragma once
/// Everything that is known of a moving mechanism at one moment, however it was found: along a trajectory in either formulation, or
/// under control.

#include "balance/foundation/base/types.hpp"

#include <vector>

namespace balance {

/// SI, world axes; moments about the run's point unless said otherwise. Of planar mechanisms vectors have z = 0 and moments lie along
/// z. What a formulation does not know stays as it is here.
template <class T>
struct SampleOf {
  using Vector = Vector3Of<T>;

  T time = 0;
  VectorXOf<T> position, velocity, acceleration;  ///< per coordinate of the mechanism; angles run on past ±π
  VectorXOf<T> effort, power;                     ///< per actuator
  Vector com = Vector::Zero(), com_velocity = Vector::Zero(), com_acceleration = Vector::Zero();
  Vector tool_position = Vector::Zero();  ///< zero without a tool
  Matrix3Of<T> tool_rotation = Matrix3Of<T>::Identity();
  T tool_angle = 0;                            ///< planar, runs on past ±π
  Vector shaking_force = Vector::Zero();       ///< rate of the linear momentum (P3 eq. 23)
  Vector shaking_moment = Vector::Zero();      ///< rate of the angular momentum (P3 eq. 27)
  Vector shaking_moment_com = Vector::Zero();  ///< rate of the angular momentum about the moving centre of mass
  Vector ground_force = Vector::Zero();        ///< what the frame feels, weight included
  Vector ground_moment = Vector::Zero();
  std::vector<Vector> joint_force;   ///< on the second body
  std::vector<Vector> joint_moment;  ///< about the joint's point on the second body
  VectorXOf<T>
      constraint_force;  ///< per constraint of the mechanism: its power is this times the speed that it keeps at zero
  T kinetic_energy = 0, potential_energy = 0;
  T total_torque = 0;  ///< root of the sum of the squared efforts; means something where all are of one kind
  T mobility = 0;      ///< smallest singular value of the scaled equations that lead the motion
  int newton_iterations = 0;

  // of a mechanism that moves under efforts
  T friction_power = 0;         ///< taken out by friction, not negative [W]
  double closure_residual = 0;  ///< largest scaled residual of the loop closures

  // of a run under control
  VectorX desired_position, tracking_error;  ///< per coordinate: desired − actual
  Vector3 desired_tool_position = Vector3::Zero(), tool_error = Vector3::Zero();  ///< desired − actual
  double tool_angle_error = 0;  ///< planar desired − actual; in space the angle between them
  VectorX sliding_variable;     ///< per sliding variable
  VectorX torque_variation;     ///< per actuator: Σ |changes of the effort| so far
  VectorX saturation;           ///< per actuator: 1 while its limit cuts, else 0

  /// Fills what follows from the rest: total_torque, and shaking_moment_com = M − (c − o) × F.
  /// @param about the run's point o
  void add_derived(const Vector& about) {
    total_torque = effort.norm();
    shaking_moment_com = shaking_moment - (com - about).cross(shaking_force);
  }
};

using Sample = SampleOf<double>;

}  // namespace balance
