#pragma once
/// Default gains of a PD controller, from the inertia at its motors all along the motion. The sampled loop is stable
/// there.

#include "balance/motion/control/control_law.hpp"

namespace balance::control {

struct PdGains {
  VectorX kp, kd;  ///< per actuator or speed [N m/rad or N/m; N m s/rad or N s/m]
  std::vector<std::string> notes;
};

/// kp = ω² I, kd = 2 ζ ω I. I is the largest inertia at the motor, or in the speed, along the motion, each alone, but limited to a
/// multiple of the smallest one that keeps the sampled damping there well below 2. ω is the frequency nearest to the
/// nominal one (lower, or also higher if no bandwidth is given) at which the loop, linearised at states of the motion
/// and sampled, is stable with these gains and with twice these gains, or the one that comes nearest to stability.
/// @param believed the controller's model of the mechanism; its friction, which only helps, is ignored
/// @param states at least one state, all coordinates
/// @param task quantities that are controlled instead of the motors' coordinates, with gains for each of them; may be
///        null
PdGains default_pd_gains(const Mechanism& believed, const Controller& controller,
                         const std::vector<DesiredState>& states, const TaskSpeeds* task = nullptr);

}  // namespace balance::control
