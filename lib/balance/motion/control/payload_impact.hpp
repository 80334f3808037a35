#pragma once
/// The jump of the rates when payloads are taken up.

#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"

namespace balance::control {

struct PayloadImpact {
  MotionOutcome outcome;
  VectorX velocity;        ///< after it, per mechanism coordinate
  double energy_loss = 0;  ///< [J], not negative
};

/// Rates after payloads that were at rest are joined to their bodies. Efforts, springs and friction are bounded and have
/// no impulse, and those of the joints do no work on motions that the loops allow. So the momentum in independent
/// coordinates stays, M ν is the same before and after, with M of what moves on each side.
/// @param before, after the mechanism without and with the payloads that are taken up; what is set down at the same
///        time is in neither
/// @param position, velocity per mechanism coordinate, loops closed
PayloadImpact take_up_payloads(const Mechanism& before, const Mechanism& after, double time, const VectorX& position,
                               const VectorX& velocity);

}  // namespace balance::control
