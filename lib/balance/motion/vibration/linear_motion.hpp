#pragma once
/// Small motion of the free coordinates of a mechanism about a reference: an equilibrium, or a motion at constant rates.
///
/// With the free coordinates f, the residual of their equation of motion without efforts is R = M f̈ + h(f, ḟ, t). About
/// f₀ with constant rates, δ = f − f₀ − ḟ₀ t satisfies to first order
///
///     M δ̈ + C δ̇ + K δ = −R₀(t),    C = ∂R/∂ḟ,    K = ∂R/∂f,
///
/// at f̈ = 0, where K has the centripetal terms and C the gyroscopic ones. R₀ vanishes at an equilibrium; driven joints
/// that turn make it and the matrices functions of the time.
///
/// Where something rolls in space, the configuration has more freedoms than the velocity. Further coordinates e of the
/// configuration follow by ė = A(f, e) ḟ + (driven rates), linearised as ε̇ = E (δ, ε) + A δ̇, and K has columns for them. On
/// those of them that accelerations do not depend on, such as the place and the heading on a level plane, no other
/// motion depends; they are left out.

#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <string>
#include <vector>

namespace balance::vibration {

/// What the driven joints do.
enum class Reference { rest, steady };

/// At one time. n free and m following coordinates. SI.
struct LinearCoefficients {
  MatrixX mass;                 ///< n×n
  MatrixX damping;              ///< n×n: ∂R/∂ḟ, gyroscopic terms included
  MatrixX stiffness;            ///< n×(n + m): ∂R/∂(f, e)
  VectorX force;                ///< n: R of the reference
  MatrixX following_damping;    ///< m×n: ∂ė/∂ḟ
  MatrixX following_stiffness;  ///< m×(n + m): ∂ė/∂(f, e)
};

struct LinearMotion {
  MotionOutcome outcome;  ///< done, or why there is no reference
  Reference reference = Reference::rest;
  std::vector<CoordinateId> coordinates;  ///< the free ones, then those that follow
  Eigen::Index free_count = 0;            ///< n
  std::vector<CoordinateId> ignored;      ///< following coordinates on which nothing depends
  VectorX position, rate;                 ///< of the coordinates at the reference; those that follow at the start
  VectorX unit;                           ///< per coordinate: the characteristic length for lengths, 1 for angles
  LinearCoefficients coefficients;        ///< averages over the motion
  /// Largest change of an entry of mass, damping or stiffness during the motion, as a part of the largest entry in units
  /// of the coordinates; 0: they are constant.
  double variation = 0;
  double period = 0;  ///< of the driven motion [s]
  /// Coefficients at evenly spaced times of a period, the first one at its start; empty: they are constant.
  std::vector<LinearCoefficients> samples;
  std::string note;  ///< on actuators, and on a reference that is one of many; empty: nothing
};

/// Along a trajectory with free coordinates: about the steady motion if the driven joints go on at constant rates, else
/// about the equilibrium with them at rest at the start. Without free coordinates all are free (AllFree). Derivatives
/// are central differences of the eighth order.
/// @param trajectory nullptr: as the mechanism is assembled
/// @throws std::invalid_argument as PartlyDrivenMechanism
LinearMotion linearise_motion(const Mechanism& mechanism, const Trajectory* trajectory);

/// R of the reference at evenly spaced times of a period, the first one at its start, one row each.
/// @param motion steady, of that trajectory
/// @throws std::invalid_argument if there is no such motion
Samples sample_reference_force(const Mechanism& mechanism, const Trajectory& trajectory, const LinearMotion& motion,
                               int samples);

}  // namespace balance::vibration
