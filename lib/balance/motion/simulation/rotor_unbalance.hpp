#pragma once
/// Unbalance of rotors in the words of ISO 21940: static and couple unbalance, unbalances in two correction planes, and
/// balance quality grades.

#include "balance/motion/study/study.hpp"

#include <string>
#include <vector>

namespace balance::simulation {

/// A vector perpendicular to a rotor's axis and fixed to it.
struct UnbalanceVector {
  double magnitude = 0;  ///< 0 if it is round-off
  double angle = 0;      ///< about the axis from RotorUnbalance::angle_reference, in [0, 2π); 0 without a magnitude
};

/// One of two planes across the axis whose unbalances are together equivalent to that of the rotor.
struct CorrectionPlane {
  std::string name;           ///< of the counterweights or points in it: "B1", "B1, B2"
  double position = 0;        ///< along the axis from the joint's point [m]
  UnbalanceVector unbalance;  ///< [kg m]
  double share = 0;           ///< of the rotor's permissible residual unbalance that may be in this plane
};

/// Balance quality along a trajectory that turns the rotor at constant speed.
struct RotorQuality {
  std::string trajectory;
  double speed = 0;    ///< Ω [rad/s], positive
  double quality = 0;  ///< G = Ω U/(m share), of the worse plane; without planes Ω e of the static unbalance [mm/s]
  double grade = 0;    ///< the best of the standard's grades that this reaches [mm/s]; 0: none
};

/// A body whose only joint is a revolute one with the ground, together with what is attached to it.
struct RotorUnbalance {
  std::string body, joint;
  double mass = 0;                      ///< [kg]
  std::string angle_reference;          ///< axis of the body's frame from which angles count: "x" or "y"
  UnbalanceVector static_unbalance;     ///< U = Σ m r [kg m]
  double eccentricity = 0;              ///< e = |U|/m [m]
  bool is_spatial = false;              ///< only then there are couple unbalance and planes
  UnbalanceVector couple_unbalance;     ///< Σ m z r with z from the plane of the centre of mass [kg m²]
  std::vector<CorrectionPlane> planes;  ///< two or none
  std::vector<RotorQuality> qualities;
};

/// The rotors of a mechanism. Correction planes are those of the counterweights on the rotor, if these lie in exactly two
/// planes; else those of the body's named points, if these do.
///
/// The permissible residual unbalance U_per = m G/Ω is shared over the planes as ISO 21940-11 does: in proportion to the
/// distance of the centre of mass from the other plane, but at least 0.3 and at most 0.7; equally if the centre of mass
/// lies outside the planes.
std::vector<RotorUnbalance> list_rotor_unbalances(const Mechanism& mechanism,
                                                  const std::vector<Trajectory>& trajectories);

/// Bodies that are rotors.
std::vector<std::string> list_rotor_names(const Mechanism& mechanism);

/// The balance quality of one rotor along one trajectory [mm/s]; NaN if its numbers are not finite.
/// @throws std::invalid_argument if the body is no rotor, or the trajectory does not turn it at a constant speed
double compute_rotor_quality(const Mechanism& mechanism, const Trajectory& trajectory, const std::string& body);

}  // namespace balance::simulation
