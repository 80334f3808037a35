#pragma once
/// Controllers of mechanisms whose counterweights move with the payload.

#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"
#include "balance/motion/study/controller_spec.hpp"

namespace balance::control {

/// The controller with the motors that the adaptations of a trajectory add (mechanics/trajectory/adaptation.hpp). They
/// get the largest of gains that have the same unit for all actuators, no limit, and an exact measurement.
/// @param mechanism, trajectory before the adaptations are modelled
/// @throws std::invalid_argument if the controller says nothing of such motors. The message is suitable for users.
Controller extend_controller(Controller controller, const Mechanism& mechanism, const Trajectory& trajectory);

}  // namespace balance::control
