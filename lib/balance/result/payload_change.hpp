#pragma once
/// A payload taken up or set down on the way, with the jump of what the actuators must do.

#include "balance/base/types.hpp"

#include <string>

namespace balance {

struct PayloadEvent {
  std::string payload;
  bool taken_up = true;      ///< else set down
  double time = 0;           ///< [s]
  double speed = 0;          ///< of its CoM, where the mechanism has it [m/s]: what moves then meets in an impact
  double angular_speed = 0;  ///< angular velocity of its body [rad/s]; 0 where it has no moment of inertia
  VectorX effort_before, effort_after;  ///< per actuator, just before and after [N m or N]
};

/// "taken up" or "set down".
inline const char* describe_payload_event(const PayloadEvent& change) {
  return change.taken_up ? "taken up" : "set down";
}

}  // namespace balance
