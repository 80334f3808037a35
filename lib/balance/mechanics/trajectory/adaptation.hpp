#pragma once
/// Counterweights that move along their bodies during a motion, to suit a payload that is taken up or set down (adaptive
/// balancing, P0 section 3).

#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

namespace balance::trajectory {

struct AdaptedMotion {
  Mechanism mechanism;
  Trajectory trajectory;  ///< without adaptations
};

/// Models every counterweight that the trajectory moves as a body of its own, on a slide with a motor. Body, joint,
/// coordinate and actuator have the counterweight's name and are the last ones of their lists; other indices do not
/// change. The coordinate is the distance from the place in the mechanism, towards the first other place [m]. It follows
/// Trajectory::courses. Without adaptations, both are returned as they are.
/// @throws std::invalid_argument if the places are not on one line, the moves are not within the motion, or the motion
///        depends on the mechanism. The message is suitable for users.
AdaptedMotion model_adaptations(const Mechanism& mechanism, const Trajectory& trajectory);

}  // namespace balance::trajectory
