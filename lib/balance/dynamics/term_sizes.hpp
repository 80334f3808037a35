#pragma once
/// How large the terms are that a figure is the sum of. Where they cancel, what is left over is round-off: a small part of their
/// size, whatever the sum.

#include "balance/base/types.hpp"

#include <array>

namespace balance {

/// One number per coordinate, actuator or joint, or a single one; all in the unit of the quantity they belong to. Empty where
/// nothing is known.
struct TermSizes {
  VectorX position, velocity, acceleration;              ///< per joint coordinate
  VectorX effort, power;                                 ///< per actuator
  VectorX total_effort;                                  ///< single, of all efforts together
  VectorX com_position, com_velocity, com_acceleration;  ///< single, as all down to potential_energy
  VectorX tool_position, tool_angle;
  VectorX shaking_force, shaking_moment;  ///< of the inertia of all bodies, and of what is added and subtracted
  VectorX moment_com;                     ///< the same about the centre of mass
  VectorX force, moment;                  ///< of inertia, loads and springs: what the ground feels
  VectorX kinetic_energy, potential_energy;
  VectorX joint_force, joint_moment;  ///< per joint
  VectorX constraint_force;           ///< per constraint on speeds
  VectorX sliding_variable;           ///< per sliding variable of a controller

  /// Each entry becomes at least `factor` times the other's.
  void raise(const TermSizes& other, double factor);
};

/// All members, for what is done to every one of them.
inline constexpr std::array all_term_sizes = {
    &TermSizes::position,      &TermSizes::velocity,     &TermSizes::acceleration,     &TermSizes::effort,
    &TermSizes::power,         &TermSizes::com_position, &TermSizes::com_velocity,     &TermSizes::com_acceleration,
    &TermSizes::tool_position, &TermSizes::tool_angle,   &TermSizes::shaking_force,    &TermSizes::shaking_moment,
    &TermSizes::force,         &TermSizes::moment,       &TermSizes::kinetic_energy,   &TermSizes::potential_energy,
    &TermSizes::joint_force,   &TermSizes::joint_moment, &TermSizes::constraint_force, &TermSizes::sliding_variable,
    &TermSizes::total_effort,  &TermSizes::moment_com};

}  // namespace balance
