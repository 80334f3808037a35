#pragma once
/// Magnitudes of the terms that quantities are sums of. Where terms cancel, the remainder is round-off: a small
/// fraction of their magnitude, whatever the sum.

#include "balance/foundation/base/types.hpp"

#include <array>

namespace balance::results {

// Threshold of round-off.

/// Relative to the terms; for a sum of a hundred terms, each computed by a few rotations.
inline constexpr double round_off_factor = 256 * 2.220446049250313e-16;

/// One number per coordinate, actuator or joint, or a single one, in the unit of the quantity. Empty if unknown.
struct TermMagnitudes {
  VectorX position, velocity, acceleration;              ///< per joint coordinate
  VectorX effort, power;                                 ///< per actuator
  VectorX total_effort;                                  ///< single, of all efforts together
  VectorX com_position, com_velocity, com_acceleration;  ///< single, as all up to potential_energy
  VectorX tool_position, tool_angle;
  VectorX shaking_force, shaking_moment;  ///< of the inertia of all bodies, and of forces added and subtracted
  VectorX moment_com;                     ///< about the centre of mass
  VectorX force, moment;                  ///< of inertia, loads and springs: reactions on the ground
  VectorX kinetic_energy, potential_energy;
  VectorX joint_force, joint_moment;           ///< per joint
  VectorX constraint_force, constraint_power;  ///< per constraint on speeds
  VectorX sliding_variable;                    ///< per sliding variable of a controller

  /// Raises each entry to at least `factor` times the entry of `other`.
  void raise_to(const TermMagnitudes& other, double factor);
};

/// All members, for loops over them.
inline constexpr std::array term_magnitude_members = {&TermMagnitudes::position,
                                                      &TermMagnitudes::velocity,
                                                      &TermMagnitudes::acceleration,
                                                      &TermMagnitudes::effort,
                                                      &TermMagnitudes::power,
                                                      &TermMagnitudes::com_position,
                                                      &TermMagnitudes::com_velocity,
                                                      &TermMagnitudes::com_acceleration,
                                                      &TermMagnitudes::tool_position,
                                                      &TermMagnitudes::tool_angle,
                                                      &TermMagnitudes::shaking_force,
                                                      &TermMagnitudes::shaking_moment,
                                                      &TermMagnitudes::force,
                                                      &TermMagnitudes::moment,
                                                      &TermMagnitudes::kinetic_energy,
                                                      &TermMagnitudes::potential_energy,
                                                      &TermMagnitudes::joint_force,
                                                      &TermMagnitudes::joint_moment,
                                                      &TermMagnitudes::constraint_force,
                                                      &TermMagnitudes::constraint_power,
                                                      &TermMagnitudes::sliding_variable,
                                                      &TermMagnitudes::total_effort,
                                                      &TermMagnitudes::moment_com};

}  // namespace balance::results
