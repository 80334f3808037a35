#pragma once
/// One moment of a run seen by differences: the coordinates go on as q + s q' + s² q''/2 for a short way either side, which has the
/// run's very position, velocity and acceleration at s = 0, and the bodies are walked to from joint to joint. Good to about 1e-10,
/// however lively the motion is.

#include "runs.hpp"

namespace laws {

/// A frame with its first and second rates, world axes.
struct Moving {
  Matrix3 R, dR, ddR;
  Vector3 p, dp, ddp;

  Vector3 angular_velocity() const;
};

/// Mass, first moment and ∫ρρᵀ dm of something rigid about the origin of its frame, in the frame's axes: forces are linear in them.
struct Mass {
  double m = 0;
  Vector3 mc = Vector3::Zero();
  Matrix3 S = Matrix3::Zero();
};

/// Bodies 1…, then attachments, then discs, each about the frame that the parameters of conditions refer to.
struct Element {
  int body;
  const balance::Disc* disc;  ///< null: moves with the body
  Mass mass;
};
std::vector<Element> elements(const Mechanism& mechanism);

struct Instant {
  std::vector<Moving> bodies;
  std::vector<Moving> elements;  ///< in the order of elements()
  /// How far joints and couplings are from agreeing, and the rates of that (see disagreement).
  VectorX open, open_rate, open_second_rate;
};
Instant instant(const Run& run, const std::vector<Element>& elements, long k);

/// Rates of momentum about the world's origin.
Total momentum_rate(const Moving& frame, const Mass& mass);
/// Momentum itself: the angular one in `moment`.
Total momentum(const Moving& frame, const Mass& mass);
double kinetic_energy(const Moving& frame, const Mass& mass);
double kinetic_energy_rate(const Moving& frame, const Mass& mass);

}  // namespace laws
