#pragma once
/// Gains of a PD controller that states none: from what its motors feel all along the motion, and such that the sampled loop is
/// stable there.

#include "balance/motion/control/control_law.hpp"

namespace balance {

struct PdGains {
  VectorX kp, kd;  ///< per actuator [N m/rad or N/m; N m s/rad or N s/m]
  std::vector<std::string> notes;
};

/// kp = ω² I, kd = 2 ζ ω I. I is the largest inertia that the motor feels along the motion, every motor alone, but so far from the
/// smallest one that the sampled damping stays well below 2 there; the next ω is taken (lower, or where no bandwidth is stated
/// also higher) with which the loop, linearised about the moments of the motion and sampled, is stable with these gains and
/// twice these, or comes nearest to that.
/// @param believed what the controller believes of the mechanism; friction, which only helps, is left out
/// @param along at least one moment, all coordinates
PdGains default_pd_gains(const Mechanism& believed, const Controller& controller,
                         const std::vector<DesiredState>& along);

}  // namespace balance
